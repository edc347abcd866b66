"""What calls functions in other processes, here or on other machines."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass

THERE, AWAY, GONE = "there", "away", "gone"


@dataclass(frozen=True)
class Engine:
    """An executor, and what is to be known of it.

    Parameters
    ----------
    executor : Executor
        The calls.
    slots : callable
        Returns how many go on at a time, now.
    threads : int
        Cores for each.
    stop : callable
        Ends what is under way, as far as that can be done.
    far : bool
        Whether workers may have another working folder, or other files.
    state : callable
        Returns whether calls are taken: ``THERE``, ``AWAY`` for now, or ``GONE`` for good with all
        that is under way.
    lost : callable
        Says why a call has no answer, for what it raised.
    shared : callable
        Returns whether another contact may be to blame, for what the call raised.
    dashboard : str
        Where a browser shows what goes on; empty where there is no such page.
    workers : str
        Whose workers are waited for where there are none, and how they are started.
    patience : float
        For how long [s].
    """

    executor: Executor
    slots: Callable[[], int]
    threads: int
    stop: Callable[[], None]
    far: bool = False
    state: Callable[[], str] = lambda: THERE
    lost: Callable[[BaseException], str] = str
    shared: Callable[[BaseException], bool] = lambda error: False
    dashboard: str = ""
    workers: str = ""
    patience: float = math.inf
