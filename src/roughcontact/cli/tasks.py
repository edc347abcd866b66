"""What the help says of each task on maps, in the order of the commands."""

from __future__ import annotations

from roughcontact.request.options import (
    COMPARE,
    CONDUCTANCE,
    FIND,
    HISTORY,
    LAW,
    ROLL,
    SOLVE,
    STRESS,
    SWEEP,
)
from roughcontact.request.tasks import TASKS

HELP = {
    **{task.name: task.help for task in TASKS},
    SOLVE: """Press a measured map against a flat or another map: pressure, contact, gap.

Give a unit with every quantity, in quotes.

\b
Example:
roughcontact solve ground.opd --load "1 N" --young "210 GPa" --poisson 0.3 \\
    --yield-strength "1 GPa" --holes fill --output out.nc --figures out
""",
    SWEEP: """Solve the contact under one load after the other: area, gap, stiffness, spots.

With --folder every finished step is saved at once, and the same command goes on where it was
interrupted.

\b
Example:
roughcontact sweep ground.opd --from "10 mN" --to "10 N" --steps 13 \\
    --young "210 GPa" --poisson 0.3 --holes fill --folder ground-sweep \\
    --output curve.csv
""",
    STRESS: """Solve the contact, and compute the elastic stress below it: where it yields first.

\b
Example:
roughcontact stress ground.opd --load "1 N" --material 100Cr6 --holes fill \\
    --output stress.nc --figures out
""",
    HISTORY: """Follow a path of loads: indentation that stays, unloading, repeated passes.

The ceiling acts as perfect plasticity of the surface: what it indents stays indented.

\b
Example:
roughcontact history ground.opd --path "1 N, 0 N, 1 N" --material 100Cr6 \\
    --holes fill --output history.csv --residual indented.x3p
""",
    ROLL: """Pass a roller, ball or map over a body again and again: does it shake down?

Every step is solved with plasticity of the volume: seconds each, minutes on larger maps. With
--folder every step is saved at once, and the same command goes on where it was interrupted.

\b
Example:
roughcontact roll ground.opd --counter-body "cylinder 5 mm 90 deg" \\
    --hertz "2.5 GPa" --boundary periodic --passes 5 --material 100Cr6 \\
    --holes fill --report rolled.html
""",
    FIND: """Find the loads at which a contact has the values asked for, each with its bracket.

\b
Example:
roughcontact find ground.opd --contact "5 %" --saturated "1 %" --first-yield \\
    --material 100Cr6 --holes fill --output loads.csv
""",
    CONDUCTANCE: """Solve the contact under one load or several: electrical and thermal resistance.

\b
Example:
roughcontact conductance ground.opd --load "1 N, 3 N" --material 42CrMo4 \\
    --counter-material 6061-T6 --holes fill --boundary periodic
""",
    LAW: """Find the law of an interface: pressure, contact, stiffness over separation.

Several files are maps of one surface, and give a mean with its scatter. Where the ceiling is
reached, unloading has a branch of its own.

\b
Example:
roughcontact law ground*.opd --from "1 MPa" --to "300 MPa" \\
    --material 42CrMo4 --holes fill --boundary periodic --output law.inp
""",
    COMPARE: """Compare several maps under the same nominal pressure: means, differences, how sure.

Files alone are maps of one surface; --group makes several, --quarters one of each map, and
--first-load sets each map beside itself after a first loading. --sampling tells how large an
area is needed.

\b
Example:
roughcontact compare --group "ground=ground*.opd" --group "honed=honed*.opd" \\
    --load "20 MPa" --material 100Cr6 --holes fill --report finish.html
""",
}
"""Task -> first sentence, what else there is to say, and an example."""
