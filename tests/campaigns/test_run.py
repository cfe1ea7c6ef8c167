"""Flights by the thousand: the same numbers whoever flies them, and nothing lost or flown twice when it is killed."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from toy_campaign import TOY, die

from uavlab.campaigns import here, processes, read_table, run
from uavlab.campaigns.run import RAISED
from uavlab.campaigns.table import open_table
from uavlab.errors import BadFile, BadInput, UavlabError

SEEDS, HERE = range(30), Path(__file__).parent


def plain(rows):
    return [{k: v for k, v in row.items() if k != "wall"} for row in rows]


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return run(TOY, SEEDS, tmp_path_factory.mktemp("alone") / "toy.jsonl")


def test_a_campaign_flies_each_seed_and_its_table_can_be_read_again(tmp_path):
    rows = run(TOY, SEEDS, tmp_path / "toy.jsonl")
    head, read = read_table(tmp_path / "toy.jsonl")
    assert [row["seed"] for row in rows] == list(SEEDS)
    assert read == rows
    assert (head.campaign, head.settings["sides"]) == ("toy", 6)


def test_two_processes_write_the_numbers_of_one(tmp_path, alone):
    assert plain(run(TOY, SEEDS, tmp_path / "toy.jsonl", processes(2))) == plain(alone)


def test_a_flight_that_raises_is_a_row_with_its_traceback_and_the_others_fly(alone):
    (row,) = (x for x in alone if x["exit"] == RAISED)
    assert row["seed"] == 13
    assert row["reason"] == "RuntimeError: thirteen"
    assert "toy_campaign.py" in row["why"]


def test_what_is_in_the_table_is_not_flown_again(tmp_path, alone):
    asked = []

    def counted(fly, seeds):
        asked.extend(seeds)
        return here(fly, seeds)

    run(TOY, range(20), tmp_path / "toy.jsonl")
    more = run(TOY, SEEDS, tmp_path / "toy.jsonl", counted)
    assert asked == list(range(20, 30))
    assert plain(more) == plain(alone)
    assert plain(run(TOY, [3, 2, 3], tmp_path / "toy.jsonl", counted)) == plain([
        alone[3],
        alone[2],
        alone[3],
    ])
    assert len(asked) == 10


KILLED = """
import sys
from pathlib import Path
sys.path[:0] = {here!r}
from toy_campaign import TOY
from uavlab.campaigns import processes, run
if __name__ == "__main__":
    run(TOY, range(30), Path({table!r}), processes({jobs}))
"""


def children(pid):
    listed = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(x) for x in listed.read_text().split()] if listed.exists() else []


def gone(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


def wait_for(done, seconds=30.0):
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="reads /proc")
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_campaign_that_is_killed_goes_on_where_it_was(tmp_path, jobs, alone):
    table, script = tmp_path / "toy.jsonl", tmp_path / "script.py"
    script.write_text(
        KILLED.format(here=[str(HERE), str(HERE.parent)], table=str(table), jobs=jobs)
    )
    environment = {**os.environ, "TOY_PAUSE": "0.05"}
    with subprocess.Popen([sys.executable, str(script)], env=environment) as process:
        wait_for(
            lambda: process.poll() or (table.is_file() and table.read_bytes().count(b"\n") >= 8)
        )
        workers = children(process.pid)
        assert len(workers) >= jobs - 1
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    wait_for(lambda: all(map(gone, workers)))  # nobody is left who waits for work

    before = table.read_bytes()
    _, kept = read_table(table)
    assert 7 <= len(kept) < 30
    rows = run(TOY, SEEDS, table)
    assert plain(rows) == plain(alone)
    assert table.read_bytes().startswith(before[: before.rfind(b"\n") + 1])
    assert table.read_bytes().count(b"\n") == 31  # the head, and each flight once


@pytest.mark.parametrize("cut", [1, 9, 60])
def test_a_last_line_that_is_cut_is_flown_again(tmp_path, cut, alone):
    table = tmp_path / "toy.jsonl"
    run(TOY, SEEDS, table)
    whole = table.read_bytes()
    table.write_bytes(whole[:-cut])
    _, kept = read_table(table)
    assert len(kept) == 29
    assert plain(run(TOY, SEEDS, table)) == plain(alone)
    assert table.read_bytes().count(b"\n") == 31


def test_a_table_whose_first_line_is_cut_is_begun_again(tmp_path, alone):
    table = tmp_path / "toy.jsonl"
    table.write_text('{"campaign": "to')
    assert plain(run(TOY, SEEDS, table)) == plain(alone)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (TOY._replace(name="toys"), "of campaign 'toy', not 'toys'"),
        (TOY._replace(settings={"sides": 8, "names": ["a", "b"]}), "sides was 6, and is 8"),
        (TOY._replace(settings={**TOY.settings, "wind": 3.0}), "wind was None, and is 3.0"),
    ],
)
def test_a_table_that_was_got_otherwise_is_refused_and_left_as_it_is(tmp_path, other, said):
    table = tmp_path / "toy.jsonl"
    run(TOY, range(3), table)
    before = table.read_bytes()
    with pytest.raises(BadInput, match=said):
        run(other, SEEDS, table)
    assert table.read_bytes() == before


def test_a_table_of_another_version_is_refused(tmp_path):
    table = tmp_path / "toy.jsonl"
    run(TOY, range(3), table)
    with (
        pytest.raises(BadInput, match=r"of version .* not '99'"),
        open_table(table, TOY.head._replace(version="99")),
    ):
        pass


@pytest.mark.parametrize("line", [b"mine", b"[1]", b'{"exit": "DONE"}', b"\xff"])
def test_a_file_that_is_no_table_is_refused_with_its_line(tmp_path, line):
    table = tmp_path / "toy.jsonl"
    run(TOY, range(3), table)
    lines = table.read_bytes().splitlines()
    table.write_bytes(b"\n".join([*lines[:2], line, *lines[2:], b""]))
    with pytest.raises(BadFile, match="line 3, is not of a campaign's table"):
        run(TOY, SEEDS, table)


def test_a_process_that_dies_is_said_and_what_was_flown_is_kept(tmp_path):
    table = tmp_path / "toy.jsonl"
    run(TOY, range(3), table)
    with pytest.raises(UavlabError, match="a process that flew was killed"):
        run(TOY._replace(fly=die), SEEDS, table, processes(2))
    assert len(read_table(table)[1]) == 3


def test_a_number_that_json_has_no_word_for_is_never_written(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        run(TOY._replace(fly=lambda seed: {"x": float("nan")}), [1], tmp_path / "toy.jsonl")
    json.loads((tmp_path / "toy.jsonl").read_bytes())


def test_no_process_at_all_is_refused():
    with pytest.raises(BadInput, match="--jobs is 0"):
        processes(0)


def test_a_folder_that_cannot_be_is_refused(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(BadInput, match="Choose another folder with --out"):
        run(TOY, SEEDS, tmp_path / "out" / "toy.jsonl")
