"""Records that somebody wrote anew: each is refused with one line that names the file and the line."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grids import each_value
from stucksolver.commands import main
from stucksolver.commands.json_lines import json_lines
from stucksolver.commands.main import main as command
from stucksolver.record import Recorder, RecordError, replay
from stucksolver.record import hash_chain as chained
from stucksolver.record.anchor import head_of
from stucksolver.record.decisions import read_decisions
from stucksolver.record.hash_chain import START, ChainWriter, read_chain, read_digests
from stucksolver.scene.json_text import DEEPEST, JsonError, depth_of, read_json
from worlds import World, drive, straight_road, thing

DEPTHS = (DEEPEST + 1, 900, 5_000, 100_000)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A complete record of a parked car that was passed."""
    with Recorder(tmp_path_factory.mktemp("record")) as recorder:
        drive(World(straight_road(), [thing("lead", 75.0)], x=66.0), 30.0, record=recorder)
    (file,) = recorder.files
    assert replay(file).ended
    return file


def rechained(path: Path, bodies: list[bytes], end: bytes = b"\n") -> Path:
    """Writes lines of any content, each a JSON object or what looks like one, in an unbroken chain."""
    before, out = START, []
    for body in bodies:
        before = hashlib.sha256(before.encode() + body).hexdigest()
        out.append(body[:-1] + b',"hash":"' + before.encode() + b'"}')
    path.write_bytes(b"\n".join(out) + end)
    return path


def bodies(file: Path) -> list[bytes]:
    return [json.dumps(data, ensure_ascii=False, separators=(",", ":")).encode() for _, data in read_chain(file)]


def nested(depth: int) -> bytes:
    return b"[" * depth + b"]" * depth


def one_line(error) -> str:
    text = str(error.value)
    assert "\n" not in text and len(text) < 600
    return text


TAILS = {
    "a space": b" ",
    "a line feed": b"\n",
    "half a line": b'{"kind":"step","time_s":1.0',
    "nothing known": b"\x00\xff\xfe",
    "a note": b"the vehicle was not to blame\n",
    "a million bytes": b"x" * 1_000_000,
}


READERS = [replay, read_digests, head_of, lambda path: list(read_decisions(path))]


@pytest.mark.parametrize(("what", "read"), each_value(TAILS, READERS))
def test_record_bytes_after_its_end_are_refused(what, read, whole, tmp_path):
    copy = tmp_path / whole.name
    copy.write_bytes(whole.read_bytes() + TAILS[what])
    with pytest.raises(RecordError) as error:
        read(copy)
    last = len(whole.read_bytes().splitlines())
    assert f"line {last + 1}: content after the record's last line" in one_line(error)


@pytest.mark.integration
@pytest.mark.parametrize("more", [b'{"kind":"step"}', b'{"kind":"fault","event":{}}', b'{"kind":"end","how":"twice"}'])
def test_record_lines_chained_on_after_its_end_are_refused(more, whole, tmp_path):
    copy = rechained(tmp_path / "record.jsonl", [*bodies(whole), more])
    with pytest.raises(RecordError, match="after the record's last line"):
        replay(copy)


@pytest.mark.integration
def test_record_without_an_end_may_have_half_a_line(whole, tmp_path):
    """A killed process leaves that."""
    copy = rechained(tmp_path / "record.jsonl", bodies(whole)[:-1])
    copy.write_bytes(copy.read_bytes() + b'{"kind":"step","time_s":1.0')
    assert replay(copy).ended is None


@pytest.mark.parametrize(("depth", "place"), each_value(DEPTHS, [0, 1, 5, -1]))
def test_record_deep_line_is_one_line(place, depth, whole, tmp_path, capsys):
    lines = bodies(whole)
    lines[place] = lines[place][:-1] + b',"deep":' + nested(depth) + b"}"
    copy = rechained(tmp_path / "record.jsonl", lines)
    with pytest.raises(RecordError, match=f"nested more than {DEEPEST} deep") as error:
        replay(copy)
    one_line(error)
    assert main(["replay", str(copy)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


NO_JSON = {
    "nothing": b"{}",
    "no object": b"[1]}",
    "no JSON": b"{kind: step}",
    "NaN": b'{"kind":"step","time_s":NaN}',
    "infinity": b'{"kind":"step","time_s":-Infinity}',
    "no text": b'{"kind":"\xff\xfe"}',
    "a long number": b'{"kind":' + b"9" * 10_000 + b"}",
    "a number for a kind": b'{"kind":7}',
    "a list for a kind": b'{"kind":["step"]}',
    "an object for a kind": b'{"kind":{"a":1}}',
    "a step of nothing": b'{"kind":"step"}',
    "a step of lists": b'{"kind":"step","in":[],"told":[],"sight":[]}',
    "told twice": b'{"kind":"step","told":[[],7],"in":{}}',
}


@pytest.mark.parametrize(("what", "place"), each_value(NO_JSON, [0, 1, 4]))
def test_record_odd_line_is_one_line(place, what, whole, tmp_path):
    lines = bodies(whole)
    lines[place] = NO_JSON[what]
    with pytest.raises(RecordError) as error:
        replay(rechained(tmp_path / "record.jsonl", lines))
    assert "record.jsonl" in one_line(error)


ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**20), 10**20) | st.floats(allow_nan=False) | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)


@pytest.mark.integration
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150, deadline=None)
@given(data=st.data())
def test_record_any_value_replaced_raises_only_record_errors(data, whole, tmp_path):
    """Replacing any value of any line raises at most a `RecordError` with a message of one line."""
    lines = [json.loads(line) for line in bodies(whole)]
    place = data.draw(st.integers(0, min(len(lines), 8) - 1))
    target, parent, key = lines[place], None, None
    while isinstance(target, (dict, list)) and target and (parent is None or data.draw(st.booleans())):
        parent = target
        key = data.draw(st.sampled_from(sorted(parent) if isinstance(parent, dict) else range(len(parent))))
        target = parent[key]
    parent[key] = data.draw(ANY_JSON)
    odd = [json.dumps(line, separators=(",", ":")).encode() for line in lines[:12]]
    try:
        replay(rechained(tmp_path / "record.jsonl", odd))
    except RecordError as error:
        assert "\n" not in str(error)


@pytest.mark.integration
def test_record_long_line_is_one_line(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(chained, "LONGEST_LINE_BYTES", 100_000)
    assert replay(whole).matches
    lines = bodies(whole)
    lines[2] = lines[2][:-1] + b',"long":"' + b"x" * 100_000 + b'"}'
    with pytest.raises(RecordError, match="line 3: longer than 100000 bytes"):
        replay(rechained(tmp_path / "record.jsonl", lines))
    (tmp_path / "zeros").write_bytes(b"\x00" * 1_000_000)
    with pytest.raises(RecordError, match="line 1: longer than"):
        replay(tmp_path / "zeros")


def test_writer_line_that_no_reader_takes_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(chained, "LONGEST_LINE_BYTES", 1000)
    writer = ChainWriter(tmp_path / "record.jsonl")
    writer.write({"kind": "begin"})
    with pytest.raises(RecordError, match="at most 1000 are allowed"):
        writer.write({"kind": "step", "long": "x" * 1000})
    writer.close()
    assert [data for _, data in read_chain(writer.path)] == [{"kind": "begin"}]


# ---- other files that are read in the same way


@pytest.mark.parametrize("depth", DEPTHS)
def test_scene_file_that_is_deep_is_one_line(depth, tmp_path, capsys):
    for text in (nested(depth), b'{"ego":' + nested(depth) + b"}", b'{"a":' * depth + b"1" + b"}" * depth):
        (tmp_path / "scene.json").write_bytes(text)
        assert command(["prompt", str(tmp_path / "scene.json")]) == 2
        assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("line", [b'{"a":' + nested(5_000) + b"}", b'{"a":NaN}', b'{"a":' + b"9" * 10_000 + b"}", b"{"])
def test_json_lines_odd_line_names_its_place(line, tmp_path):
    file = tmp_path / "lines.jsonl"
    file.write_bytes(b'{"a": 1}\n' + line + b"\n")
    with pytest.raises(Exception, match=r"lines.jsonl:2: invalid JSON") as error:
        list(json_lines(file))
    one_line(error)


@given(st.integers(0, 3 * DEEPEST))
def test_read_json_depth_is_counted(depth):
    value = 1
    for k in range(depth):
        value = {"a": value} if k % 2 else [0, value]
    assert depth_of(value) == min(depth, DEEPEST + 1)
    if depth <= DEEPEST:
        assert read_json(json.dumps(value)) == value
    else:
        with pytest.raises(JsonError):
            read_json(json.dumps(value))
