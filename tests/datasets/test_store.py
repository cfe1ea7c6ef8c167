"""Fetching: the folder, the cache, the network and what can be wrong with each."""

import hashlib
import http.server
import threading
from functools import partial

import pytest

from uavlab import datasets
from uavlab.datasets import catalogue, store
from uavlab.errors import BadFile, UnknownName

CONTENT = b"time,flown\n0,1\n"


@pytest.fixture
def tiny(monkeypatch, tmp_path):
    """A catalogue of one small file, an empty cache, and no folder."""
    data = catalogue.Dataset(
        "tiny", "rtk", "some/GT.csv", "owner/repo/commit/some/GT.csv",
        hashlib.sha256(CONTENT).hexdigest(), len(CONTENT), "a table", "CC0", "nobody",
    )  # fmt: skip
    monkeypatch.setattr(catalogue, "DATASETS", {"tiny": data})
    monkeypatch.setattr(catalogue, "RAW", "http://127.0.0.1:9")
    monkeypatch.setattr(store, "cache", lambda: tmp_path / "cache")
    monkeypatch.delenv("UAVLAB_DATA", raising=False)
    for proxy in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(proxy, raising=False)
    return data


@pytest.fixture
def server(tiny, monkeypatch, tmp_path):
    """A web server that holds the file; what it was asked for is in `server.asked`."""
    file = tmp_path / "web" / tiny.address
    file.parent.mkdir(parents=True)
    file.write_bytes(CONTENT)
    asked = []

    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *args):
            asked.append(self.path)

    handler = partial(Handler, directory=str(tmp_path / "web"))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as web:
        web.asked, web.file = asked, file
        monkeypatch.setattr(catalogue, "RAW", f"http://127.0.0.1:{web.server_address[1]}")
        thread = threading.Thread(target=web.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        yield web
        web.shutdown()
        thread.join()


def test_it_is_fetched_once_and_then_taken_from_the_cache(server):
    assert datasets.fetch("tiny").read_bytes() == CONTENT
    assert datasets.fetch("tiny").read_bytes() == CONTENT
    assert len(server.asked) == 1


def test_a_damaged_cache_is_fetched_again(server):
    datasets.fetch("tiny").write_bytes(CONTENT[:3])
    assert datasets.fetch("tiny").read_bytes() == CONTENT


def test_other_bytes_from_the_network_are_refused_and_not_kept(server, tmp_path):
    server.file.write_bytes(b"something else")
    with pytest.raises(BadFile, match="is not the file it should be"):
        datasets.fetch("tiny")
    assert not [p for p in (tmp_path / "cache").rglob("*") if p.is_file()]


def test_without_network_the_error_names_both_cures(tiny):
    with pytest.raises(
        BadFile, match=r"Go online once, or put some/GT\.csv into a folder and set UAVLAB_DATA"
    ):
        datasets.fetch("tiny")


def test_the_folder_comes_before_the_network(tiny, monkeypatch, tmp_path):
    (tmp_path / "some").mkdir()
    (tmp_path / "some" / "GT.csv").write_bytes(CONTENT)
    monkeypatch.setenv("UAVLAB_DATA", str(tmp_path))
    assert datasets.fetch("tiny") == tmp_path / "some" / "GT.csv"


@pytest.mark.parametrize(
    ("content", "why"), [(CONTENT[:5], "cut short: 5 of 15 bytes"), (b"x" * 15, "sha256 is not")]
)
def test_a_file_in_the_folder_is_checked_too(tiny, monkeypatch, tmp_path, content, why):
    (tmp_path / "some").mkdir()
    (tmp_path / "some" / "GT.csv").write_bytes(content)
    monkeypatch.setenv("UAVLAB_DATA", str(tmp_path))
    with pytest.raises(BadFile, match=why):
        datasets.fetch("tiny")


def test_a_folder_without_the_file_is_said_with_the_cure(tiny, monkeypatch, tmp_path):
    monkeypatch.setenv("UAVLAB_DATA", str(tmp_path))
    with pytest.raises(BadFile, match="unset UAVLAB_DATA to fetch it"):
        datasets.fetch("tiny")


def test_an_unknown_name_gets_a_suggestion(tiny):
    with pytest.raises(UnknownName, match="Did you mean 'tiny'"):
        datasets.fetch("tinny")


def test_every_address_names_a_commit_and_every_hash_is_whole():
    for name in datasets.names():
        data = datasets.about(name)
        assert data.url.startswith("https://raw.githubusercontent.com/")
        assert len(data.address.split("/")[2]) >= 7
        assert len(data.sha256) == 64
