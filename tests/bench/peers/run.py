"""Runs every program of the comparison and leaves the lines in results.jsonl and the picture beside PEERS.md; `cargo xtask peers` makes the rest.

    python run.py --haptor PATH --parry PATH [--rounds N] [--seconds S]

Rounds are interleaved: in each, every program runs once, so that what the machine does meanwhile falls on all. Physics runs once: it is no measurement of time.
"""

import argparse
import datetime
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PEERS = ("haptor", "fem", "parry", "mujoco", "drake", "coal")
# libraries that would start threads of their own
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")}


def ask(peer: str, *words: str) -> list[dict]:
    """The lines of one program; one that fails says so in a line."""
    print(f"  {peer} {' '.join(words)}", file=sys.stderr, flush=True)
    command = [sys.executable, str(HERE / f"{peer}_peer.py"), *words]
    # some leave a log where they run
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(command, capture_output=True, text=True, env=os.environ | ONE_THREAD, cwd=folder)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or [f"ended with {done.returncode}"])[-1]
        lines.append({"cannot": f"run here ({words[0]})", "peer": peer, "version": "", "reason": reason})
    return lines


def about(rounds: int, seconds: float, lines: list[dict], load: float) -> dict:
    """The line about the run, with the truth that its physics is compared with."""
    import common

    pairs = sorted({(line["nu"], line["depth_mm"]) for line in lines if line.get("physics") == "press-twist"})
    truths = [(nu, depth, common.truth(nu, depth * 1.0e-3)) for nu, depth in pairs]
    model = next((line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")), platform.machine())
    return {"machine": f"{os.cpu_count()} cores of an {model}, Linux {platform.release()}, Python {platform.python_version()}", "date": f"{datetime.date.today():%d %B %Y}",
            "rounds": rounds, "seconds": seconds, "load": [load, os.getloadavg()[0]], "sliding": common.sliding_truth(),
            "truth": [{"nu": nu, "depth_mm": depth, "force_N": row["F_N"], "twist_deg": row["twist_deg"], "torque_Nm": row["T_Nm"]} for nu, depth, row in truths]}


def draw(run: dict, lines: list[dict], depth_mm: float, file: Path) -> None:
    """Torque against twist of every program at one depth, and the truth."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    shown = ("point", "paper 64", "bristle 64", "influence 52", "rigid, condim 4", "rigid, condim 4, impratio 10, noslip 10", "flex 6 x 6 x 6", "hint 1 mm, polygons")
    figure, axes = pyplot.subplots(figsize=(11.0, 5.0), layout="constrained")
    for truth, style in zip([t for t in run["truth"] if t["depth_mm"] == depth_mm], (":", "-")):
        axes.plot(truth["twist_deg"], truth["torque_Nm"], style, color="black", linewidth=3.0, alpha=0.5, label=f"truth, nu = {truth['nu']}")
    ours = [line for line in lines if line.get("physics") == "press-twist" and line["depth_mm"] == depth_mm]
    for line in ours:
        if line["case"] in shown or line["peer"].startswith("condensed"):
            dashes = "-" if line["peer"] == "haptor" else "--"
            axes.plot(line["twist_deg"], line["torque_Nm"], dashes, marker=".", label=f"{line['peer']}, {line['case']}")
    axes.set(xlabel="twist [degrees]", ylabel="torque [N m]", title=f"Ball of 20 mm, {depth_mm:g} mm into the rubber cube, twisted", xlim=(0.0, 60.0), ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(file, dpi=100, metadata={"Software": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--haptor", required=True, help="the tool")
    parser.add_argument("--parry", required=True, help="the program parry-peer")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=0.3, help="time for each case [s]")
    args = parser.parse_args()
    os.environ |= {"HAPTOR": str(Path(args.haptor).resolve()), "PARRY_PEER": str(Path(args.parry).resolve())}
    load, lines = os.getloadavg()[0], []
    for peer in PEERS:
        lines += ask(peer, "physics")
    for number in range(args.rounds):
        for peer in PEERS:
            lines += [line if "cannot" in line else line | {"round": number} for line in ask(peer, "time", str(args.seconds))]
    run = about(args.rounds, args.seconds, lines, load)
    draw(run, lines, 3.0, HERE.parent / "peers.png")
    (HERE / "results.jsonl").write_text("".join(json.dumps(line) + "\n" for line in [run, *lines]))


if __name__ == "__main__":
    main()
