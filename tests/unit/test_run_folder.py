"""Where a run is kept: names that every part of a mission can use, or a refusal before anything starts."""

import os

import pytest

from tethernet_bringup.mission.run_folder import RunFolderError, make_run_folder


@pytest.mark.parametrize("name", ["café", "漢字", "sp ace", "quo'te\"", "a:=b", "{}", "new\nline", "$(x)", "-r x:=y"])
def test_odd_names_in_utf8_are_used(tmp_path, name):
    assert make_run_folder(str(tmp_path / name), "zenit_8mu", 1).logs.is_dir()


def test_a_name_that_is_not_in_utf8_is_refused_before_anything_is_made(tmp_path):
    """The middleware's parameters are UTF-8: a node that were given such a path would end with a parser's message."""
    parent = tmp_path / os.fsdecode(b"caf\xe9")
    with pytest.raises(RunFolderError, match="is not in UTF-8") as caught:
        make_run_folder(str(parent), "zenit_8mu", 1)
    assert caught.value.usage
    assert str(caught.value).isascii()
    assert not parent.exists()


def test_a_locale_with_another_encoding_is_refused(tmp_path, monkeypatch):
    """Under ISO 8859-1 the text of a path is not what the nodes would open."""
    monkeypatch.setattr(os, "fsencode", lambda path: str(path).encode("latin-1"))
    with pytest.raises(RunFolderError, match=r"LC_ALL=C\.UTF-8"):
        make_run_folder(str(tmp_path / "café"), "zenit_8mu", 1)
    assert make_run_folder(str(tmp_path / "plain"), "zenit_8mu", 1).logs.is_dir()
