"""What the set-up shows while the kernels compile."""

from tethernet_sim import fly, warm_up


def test_the_newest_line_names_the_system_that_is_being_compiled(monkeypatch, capsys):
    shown = []
    monkeypatch.setattr(fly, "fly", lambda scenario, _: shown.append((scenario.system.name, capsys.readouterr().out)))
    assert warm_up.main() == 0
    assert [name for name, _ in shown] == ["zenit_4mu", "zenit_8mu", "hexagonal_6mu"]
    for name, out in shown:
        assert out.endswith(f"compiling the physics of {name}\n"), "a line that is not whole is not shown"
    assert capsys.readouterr().out.startswith("compiled that of hexagonal_6mu in ")
