"""Which real flights there are: where they come from, what they must hash to, whom to cite."""

from __future__ import annotations

from typing import NamedTuple

from uavlab.errors import UnknownName

RAW = "https://raw.githubusercontent.com"
PX4 = "PX4/pyulog/3cf1779"
PHANTOM = "ansfl/Quadrotor-Dead-Reckoning-with-Multiple-Inertial-Sensors/4b129e4"


class Dataset(NamedTuple):
    """One file of a real recording."""

    name: str
    kind: str  # px4, rtk or dot: which reader it is for
    path: str  # in the folder UAVLAB_DATA, and in the cache
    address: str  # owner/repository/commit/path on GitHub
    sha256: str
    size: int  # [bytes]
    summary: str
    licence: str
    citation: str

    @property
    def url(self) -> str:
        """Where it is fetched from."""
        return f"{RAW}/{self.address}"


def _phantom(
    flight: str, folder: str, about: str, files: dict[str, tuple[int, str]]
) -> list[Dataset]:
    """The three files of one Phantom 4 flight."""
    kinds = {"GT": ("rtk", "RTK track and attitude, 10 Hz"), "IMU_1": ("dot", "first Xsens DOT, 120 Hz"),
             "IMU_2": ("dot", "second Xsens DOT, 120 Hz")}  # fmt: skip
    return [
        Dataset(
            f"phantom4-{flight}" + ("" if part == "GT" else f"/{part}"),
            kinds[part][0],
            f"ansfl-phantom4/{folder}/{part}.csv",
            f"{PHANTOM}/{folder}/{part}.csv",
            sha256,
            size,
            f"DJI Phantom 4 RTK, {about}: {kinds[part][1]}",
            "CC BY 4.0",
            "A. Hurwitz and I. Klein, Quadrotor Dead Reckoning with Multiple Inertial Sensors, 2023",
        )
        for part, (size, sha256) in files.items()
    ]


DATASETS = {
    d.name: d
    for d in [
        Dataset(
            "px4-sample",
            "px4",
            "px4-sample/sample.ulg",
            f"{PX4}/test/sample.ulg",
            "81952e6059bc095717e7911c010e07f85749d6b04d332a5ffc51575a3fd0a558",
            4053364,
            "PX4 on an AUAV X2.1 handled on the bench, 69 s: inertial sensors at 250 Hz, EKF2 attitude, tilt to 23°",
            "BSD-3-Clause",
            "PX4 Development Team, pyulog (test/sample.ulg), commit 3cf1779",
        ),
        *_phantom("horizontal-8", "Horizontal/path_8", "horizontal path 8, 34 s", {
            "GT": (37710, "9dfbc0ead6c8fba520c84cad613043e87a2c08e36dec338810750b2db861930d"),
            "IMU_1": (529682, "bda791252c82245e9fc0ce0bb7211172636362abbb18019b6d39c73fdf13de9a"),
            "IMU_2": (525379, "877debe83940a3a03d8c4d44f0e9ac5ab274a53b8cb6711eed9df233d20f83ae"),
        }),
        *_phantom("horizontal-12", "Horizontal/path_12", "horizontal path 12, 18 s", {
            "GT": (21276, "9011480e9d60f768cc24e194d020dff8068676b73ebd0d91a4289e169e3e83d1"),
            "IMU_1": (289157, "7c5088b97cc68a5583586a36566553231fcd73827e449c9350ed1d0cbd80f6b9"),
            "IMU_2": (287946, "d4c06624ea5edfb3cafd2ed3d962560179fa97c1e767216f28b7d3d7dd693dbf"),
        }),
        *_phantom("horizontal-22", "Horizontal/path_22", "horizontal path 22, 32 s", {
            "GT": (35556, "8db7b38f4be5949af803fd591d10c302bc967ad0e4125f36fc3d2edd5a892a03"),
            "IMU_1": (494050, "087607bea4aa96adf6bd3ea2bf0f986e59bcc2bbceba8f71f49ea7509c046543"),
            "IMU_2": (490425, "b2a51265477a8f6a195adee8c19c3fd92912322ca5e5f6695376957480614407"),
        }),
        *_phantom("line-1", "StraightLine/path_1", "straight line 1, 24 s", {
            "GT": (26608, "42ec4083cbdac169697a2f81bd0e62e469d3597b263fb9bb3819bfd76978423e"),
            "IMU_1": (375408, "6e77957c1d11666a46f39080f6035735f1e5a4274023bf04c44cf27c2f9c73e1"),
            "IMU_2": (374486, "7204547e09d5958b3c8534425ce00bd570fa0c486bfc84502168fa6d8481956e"),
        }),
        *_phantom("vertical-1", "Vertical/path_1", "vertical path 1, 33 s", {
            "GT": (36527, "02b4aeb3c4e0b718ee4f6abd73914925d09fc2b3f59949431020e7657a4c75d9"),
            "IMU_1": (509970, "bb085febb98671e6ba2088803d3fde6fa33fdb7f55e6e1e5be62c39abed6d033"),
            "IMU_2": (505964, "fc68e8d63234285841c78062463b045968ce103ce7e5aff6581f2cdf39e78d42"),
        }),
    ]
}  # fmt: skip


def names() -> list[str]:
    """The names that `fetch` knows."""
    return list(DATASETS)


def about(name: str) -> Dataset:
    """What is known of a dataset: source, licence, citation.

    Raises
    ------
    UnknownName
        There is no such dataset.
    """
    if name not in DATASETS:
        raise UnknownName("dataset", name, DATASETS)
    return DATASETS[name]
