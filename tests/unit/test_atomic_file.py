"""Files are there as a whole or not at all."""

import pytest

from tethernet_core.atomic_file import write_text, write_whole


def test_a_writer_that_fails_half_way_leaves_the_old_file_and_nothing_beside(tmp_path):
    path = tmp_path / "table.csv"
    write_text(path, "old")

    def half(partial):
        assert partial.suffix == ".csv"
        partial.write_text("ne")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        write_whole(path, half)
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["table.csv"]


@pytest.mark.parametrize("durable", [True, False])
def test_the_new_file_takes_the_place_of_the_old_one(tmp_path, durable):
    path = tmp_path / "note.txt"
    write_text(path, "old", durable)
    write_text(path, "neu: ö\n", durable)
    assert path.read_bytes() == "neu: ö\n".encode()
    assert list(tmp_path.iterdir()) == [path]
