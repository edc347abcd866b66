"""All tasks: one row each."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.request import leakage

TASKS = (leakage.TASK,)
BY_NAME = {task.name: task for task in TASKS}
OPTIONS = tuple(replace(option, fits=(task.name,)) for task in TASKS for option in task.options)
