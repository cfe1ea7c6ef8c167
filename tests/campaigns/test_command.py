"""`uavlab campaign`: what it prints, what it writes, and how a flight is looked at again."""

import sys
from html.parser import HTMLParser
from types import ModuleType

import pytest
from toy_campaign import TOY

from uavlab.__main__ import main
from uavlab.campaigns import spec
from uavlab.campaigns.record import load_record, save_record
from uavlab.errors import BadFile


@pytest.fixture(autouse=True)
def toy(monkeypatch, tmp_path):
    module = ModuleType("uavlab.campaigns.toy")
    module.CAMPAIGN = TOY
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(spec, "NAMES", ("toy",))
    monkeypatch.chdir(tmp_path)


def test_it_prints_the_table_and_writes_rows_record_and_page(tmp_path, capsys):
    assert main(["campaign", "toy", "--runs", "30"]) == 1
    said = capsys.readouterr().out
    assert "throw        flights  DONE  CRASH  RAISED  not as it should [95 %]" in said
    assert "A dice." in said
    assert "seed 13 · RAISED" in said
    out = tmp_path / "campaigns" / "toy"
    assert sorted(p.name for p in out.iterdir()) == ["toy.html", "toy.json", "toy.jsonl"]
    kept = load_record(out / "toy.json")
    assert (kept.campaign, kept.runs) == ("toy", 30)
    assert kept.command == "uavlab campaign toy --runs 30 --seed 0"
    assert kept.summary == TOY.summed([*_rows(out)])
    assert load_record(save_record(kept, out / "again.json")) == kept


def _rows(out):
    from uavlab.campaigns import read_table

    return read_table(out / "toy.jsonl")[1]


def test_all_as_it_should_is_exit_code_0():
    assert main(["campaign", "toy", "--runs", "3", "--seed", "1"]) == 0


class Read(HTMLParser):
    """Opened and closed tags, text, and where links go."""

    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.text, self.opened = [], [], "", []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.opened.append(tag)
        self.links += [v for k, v in attributes if k in {"href", "src"}]
        if tag not in {"meta", "br"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_the_page_asks_nobody_for_anything_and_tells_how_to_fly_a_failure_again(tmp_path):
    main(["campaign", "toy", "--runs", "30", "--out", "my runs"])
    page = Read((tmp_path / "my runs" / "toy.html").read_text())
    assert page.open == []
    assert page.links == []
    assert "A dice <thrown>" in page.text
    assert "<high>" in page.text
    assert "uavlab campaign toy --fly 13 --out 'my runs'" in page.text
    assert page.opened.count("details") == len(
        load_record(tmp_path / "my runs" / "toy.json").summary.worth["Fell off the table"]
    )


@pytest.mark.slow
def test_a_flight_that_is_flown_again_has_its_log_and_its_replay_and_the_page_leads_there(
    tmp_path, capsys
):
    out = tmp_path / "campaigns" / "toy"
    crashed = TOY.summed([TOY.fly(s) | {"seed": s} for s in range(12)]).worth["Fell off the table"]
    seed = crashed[0]["seed"]
    assert main(["campaign", "toy", "--fly", str(seed)]) == 1
    said = capsys.readouterr().out
    assert f"seed {seed} · CRASH" in said
    names = {p.name for p in (out / "flights" / str(seed)).iterdir()}
    assert {"log.npz", "replay.html", "flight.png"} <= names
    main(["campaign", "toy", "--runs", "12"])
    assert Read((out / "toy.html").read_text()).links == [f"flights/{seed}/replay.html"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["dice"], "no campaign named 'dice'"),
        (["toy", "--runs", "0"], "--runs is 0; it must be 1 or more"),
        (["toy", "--jobs", "0"], "--jobs is 0; it must be 1 or more"),
        (["toy", "--seed", "-1"], "--seed is -1; it must be 0 or more"),
        (["toy", "--fly", "-1"], "--fly is -1; it must be 0 or more"),
        (["toy", "--out", "/dev/null/x"], "Choose another folder with --out"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_line(words, said, capsys):
    assert main(["campaign", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("text", ["", "[]", '{"summary": {"lines": [{}]}}'])
def test_what_is_not_a_record_is_refused(tmp_path, text):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(BadFile, match="not the record of a campaign"):
        load_record(tmp_path / "x.json")
