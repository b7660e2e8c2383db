"""Heads kept elsewhere find a chain that was made anew, and one whose end was cut off."""

from __future__ import annotations

import pytest

from stucksolver.commands import main
from stucksolver.record import Anchor, RecordError, check_anchor, head_of
from stucksolver.record.hash_chain import ChainWriter, read_chain


def written(path, events):
    writer = ChainWriter(path)
    for data in events:
        writer.write(data)
    writer.close()
    return path


def numbers(count):
    return [{"kind": "tick", "k": k} for k in range(count)]


@pytest.fixture
def record(tmp_path):
    return written(tmp_path / "a.jsonl", numbers(6))


def test_the_head_is_the_last_line_and_its_hash(record):
    head = head_of(record)
    assert head.line == 6
    assert record.read_bytes().endswith(f'"hash":"{head.digest}"}}\n'.encode())
    check_anchor(record, head)


def test_check_anchor_longer_record_is_accepted(tmp_path, record):
    """A record that has grown still matches its anchor."""
    check_anchor(written(tmp_path / "longer.jsonl", numbers(9)), head_of(record))


def test_a_chain_made_anew_is_found(tmp_path, record):
    lines = [data for _, data in read_chain(record)]
    lines[2]["k"] = 99
    forged = written(tmp_path / "forged.jsonl", lines)
    assert len(list(read_chain(forged))) == 6
    with pytest.raises(RecordError, match=r"forged\.jsonl, line 6: .*rewritten"):
        check_anchor(forged, head_of(record))


@pytest.mark.parametrize("kept", [1, 5])
def test_lines_cut_off_at_the_end_are_found(tmp_path, record, kept):
    short = tmp_path / "short.jsonl"
    short.write_bytes(b"".join(record.read_bytes().splitlines(keepends=True)[:kept]))
    assert len(list(read_chain(short))) == kept
    with pytest.raises(RecordError, match=rf"anchor is for line 6, but the record has only {kept} lines"):
        check_anchor(short, head_of(record))


def test_check_anchor_in_middle_ignores_later_lines(tmp_path, record):
    """An anchor in the middle of a record covers only the lines up to it."""
    middle = Anchor(3, head_of(written(tmp_path / "begun.jsonl", numbers(3))).digest)
    check_anchor(written(tmp_path / "other.jsonl", [*numbers(3), {"kind": "end"}]), middle)


# ---- the command


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A real record of its own, copied by whoever changes it."""
    from stucksolver.record import Recorder
    from worlds import World, drive, straight_road, thing

    with Recorder(tmp_path_factory.mktemp("whole")) as recorder:
        drive(World(straight_road(), [thing("lead", 75.0)], x=66.0), 8.0, record=recorder)
    return recorder.files[0]


@pytest.mark.integration
def test_heads_are_saved_and_checked_without_naming_the_records_again(whole, tmp_path, capsys):
    heads = tmp_path / "heads.txt"
    assert main(["replay", str(whole), "--save-heads", str(heads)]) == 0
    assert str(heads) in capsys.readouterr().out
    head = head_of(whole)
    assert heads.read_text(encoding="utf-8") == f"{head.digest}  {head.line}  {whole.as_posix()}\n"
    assert main(["replay", "--anchors", str(heads)]) == 0
    assert f"agrees with the anchor at line {head.line}" in capsys.readouterr().out


@pytest.mark.integration
def test_replay_forged_record_is_rejected_only_with_anchor(whole, tmp_path, capsys):
    """A record whose chain was written anew replays without its anchor and is rejected with it."""
    record, heads = tmp_path / "r.jsonl", tmp_path / "heads.txt"
    record.write_bytes(whole.read_bytes())
    assert main(["replay", str(record), "--save-heads", str(heads)]) == 0
    lines = [data for _, data in read_chain(record)]
    lines[0]["written"] = "1999-01-01T00:00:00+00:00"
    record.unlink()
    written(record, lines)
    assert main(["replay", str(record)]) == 0
    assert main(["replay", str(record), "--anchors", str(heads)]) == 2
    assert "was rewritten" in capsys.readouterr().err


def test_saved_heads_are_never_written_over(whole, tmp_path, capsys):
    heads = tmp_path / "heads.txt"
    heads.write_text("mine", encoding="utf-8")
    assert main(["replay", str(whole), "--save-heads", str(heads)]) == 2
    assert heads.read_text(encoding="utf-8") == "mine"
    assert "File exists; name a new file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "names no record"),
        ("abc  3  r.jsonl\n", "line 1: expected `HASH  LINE  PATH`"),
        (f"{'0' * 64}  0  r.jsonl\n", "line 1: expected"),
        (f"{'0' * 64}  1  r.jsonl\n" * 2, "line 2: expected `HASH  LINE  PATH`, each record once"),
    ],
)
def test_replay_malformed_anchor_file_is_rejected_with_line(text, told, tmp_path, capsys):
    """A file without valid anchors is rejected with its name and, where it has one, the wrong line."""
    (tmp_path / "heads.txt").write_text(text, encoding="utf-8")
    assert main(["replay", "--anchors", str(tmp_path / "heads.txt")]) == 2
    error = capsys.readouterr().err
    assert told in error and "heads.txt" in error


def test_a_record_that_its_anchors_do_not_name_is_refused(whole, tmp_path, capsys):
    (tmp_path / "heads.txt").write_text(f"{'0' * 64}  1  other.jsonl\n", encoding="utf-8")
    assert main(["replay", str(whole), "--anchors", str(tmp_path / "heads.txt")]) == 2
    assert f"has no entry for {whole}" in capsys.readouterr().err


def test_nothing_to_replay_is_said_in_a_line(capsys):
    assert main(["replay"]) == 2
    assert capsys.readouterr().err == "error: give a record, intervention-….jsonl, or --anchors FILE\n"


# ---- what is no record


@pytest.mark.parametrize("content", [b"# A page\n\nText.\n", b"\x7fELF\x00\xff\n\x00", b'{"kind": "begin"}\n', b"x"])
def test_replay_other_file_is_rejected_in_one_line(content, tmp_path, capsys):
    """A file that is not a record is rejected with a message of one line."""
    (tmp_path / "page.md").write_bytes(content)
    assert main(["replay", str(tmp_path / "page.md")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "page.md is not a record" in error and "intervention-" in error and "changed" not in error


def test_an_empty_file_is_told_so(tmp_path, capsys):
    (tmp_path / "empty.jsonl").write_bytes(b"")
    assert main(["replay", str(tmp_path / "empty.jsonl")]) == 2
    assert "empty file, not a record" in capsys.readouterr().err
