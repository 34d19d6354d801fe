"""Type stubs of the extension module; its docstrings say what everything is."""

import enum
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

__version__: str

_Path = str | bytes | os.PathLike[str] | os.PathLike[bytes]
_Option = bool | int | float | str | os.PathLike[str] | None
_Map = TypeVar("_Map", bound="LearnedMap")

class FileError(OSError):
    filename: str | None
    def __init__(self, message: str, filename: str | None = None) -> None: ...
    def __str__(self) -> str: ...

class MissingFileError(FileError, FileNotFoundError): ...

class State(enum.IntEnum):
    UNOBSERVED = -1
    UNKNOWN = 0
    FREE = 1
    OCCUPIED = 2

class Estimates(NamedTuple):
    prob: npt.NDArray[np.float64]  # (N,), NaN where nothing was observed
    variance: npt.NDArray[np.float64]  # (N,)
    state: npt.NDArray[np.int8]  # (N,), of State

class Cells(NamedTuple):
    centre: npt.NDArray[np.float64]  # (M, 3) [m]
    size: float  # [m]
    prob: npt.NDArray[np.float64]  # (M,)
    variance: npt.NDArray[np.float64]  # (M,)
    state: npt.NDArray[np.int8]  # (M,), of State
    evidence: npt.NDArray[np.float64]  # (M, K), see LearnedMap.evidence_names

class Rays(NamedTuple):
    hit: npt.NDArray[np.bool_]  # (N,)
    end: npt.NDArray[np.float64]  # (N, 3) [m]

class LearnedMap:
    alias: ClassVar[str]
    threads: int
    @property
    def options(self) -> Mapping[str, bool | int | float | str | None]: ...
    @property
    def resolution(self) -> float: ...
    @property
    def bounds(self) -> npt.NDArray[np.float64] | None: ...
    @property
    def is_empty(self) -> bool: ...
    @property
    def evidence_names(self) -> tuple[str, ...]: ...
    @property
    def ray_counts(self) -> dict[str, int]: ...
    @property
    def report(self) -> dict[str, Any] | None: ...
    def insert(
        self,
        points: npt.ArrayLike,
        *,
        origin: npt.ArrayLike | None = None,
        pose: npt.ArrayLike | None = None,
        covariance: npt.ArrayLike | None = None,
        returned: npt.ArrayLike | None = None,
        min_range: float = 0.0,
        max_range: float = 0.0,
        beam_width: float = 0.0,
        beam_height: float = 0.0,
        range_std: float = 0.0,
    ) -> bool: ...
    def query(self, points: npt.ArrayLike) -> Estimates: ...
    def cells(self) -> Cells: ...
    def cast_rays(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        max_range: float | None = None,
        *,
        ignore_unknown: bool = False,
    ) -> Rays: ...
    def log_likelihood(self, points: npt.ArrayLike, poses: npt.ArrayLike) -> npt.NDArray[np.float64]: ...
    def save(self, path: _Path) -> None: ...
    def clear(self) -> None: ...
    def __eq__(self, other: object) -> bool: ...
    def __copy__(self: _Map) -> _Map: ...
    def __deepcopy__(self: _Map, memo: dict[int, Any]) -> _Map: ...
    def __repr__(self) -> str: ...
    def __str__(self) -> str: ...

class BGKMap(LearnedMap):
    def __init__(self, **options: _Option) -> None: ...
    @staticmethod
    def load(path: _Path) -> BGKMap: ...
    def merge(self, other: BGKMap) -> None: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, state: bytes) -> None: ...

class GPMap(LearnedMap):
    def __init__(self, **options: _Option) -> None: ...
    @staticmethod
    def load(path: _Path) -> GPMap: ...
    def merge(self, other: GPMap) -> None: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, state: bytes) -> None: ...

class HilbertMap(LearnedMap):
    def __init__(self, **options: _Option) -> None: ...
    @staticmethod
    def load(path: _Path) -> HilbertMap: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, state: bytes) -> None: ...

class OverlappingHilbertMap(LearnedMap):
    def __init__(self, **options: _Option) -> None: ...
    @staticmethod
    def load(path: _Path) -> OverlappingHilbertMap: ...
    def merge(self, other: OverlappingHilbertMap) -> None: ...
    @property
    def model_count(self) -> int: ...
    def model_pose(self, model: int) -> npt.NDArray[np.float64]: ...
    def set_model_pose(self, model: int, pose: npt.ArrayLike) -> None: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, state: bytes) -> None: ...

def load(path: _Path) -> BGKMap | GPMap | HilbertMap | OverlappingHilbertMap: ...
def build(
    log: _Path | Sequence[_Path],
    map: str | type[LearnedMap] | None = "bgk",
    *,
    config: _Path | None = None,
    onto: _Path | None = None,
    poses: _Path | None = None,
    sensor_origin: npt.ArrayLike | None = None,
    cloud_frame: str | None = None,
    standing_still: bool | None = None,
    sensors: str | Sequence[str] | None = None,
    every: int | None = None,
    from_time: float | str | None = None,
    to_time: float | str | None = None,
    ping_beam: float | Sequence[float] | None = None,
    ping_angles: str | None = None,
    ping_threshold: float | Sequence[float] | None = None,
    ping_dead_zone: float | None = None,
    ping_separation: float | None = None,
    ping_echoes: int | None = None,
    threads: int | None = None,
    strict: bool | None = None,
    progress: Callable[[int, int, str], object] | None = None,
    **options: _Option,
) -> BGKMap | GPMap | HilbertMap | OverlappingHilbertMap: ...
def evaluate(
    map: LearnedMap,
    truth: _Path | tuple[npt.ArrayLike, npt.ArrayLike],
    surface: _Path | None = None,
    thresholds: Sequence[float] | None = None,
) -> dict[str, Any]: ...
