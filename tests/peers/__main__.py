"""``python -m tests.peers``: train all peers, each in its environment, and write what came of them."""

import argparse
import importlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.whole_files import write_json

PEERS = {
    "ours": ("lawn-sb3 MAPPO", "on_sb3:ours", None),
    "sb3-ppo": ("Stable-Baselines3 PPO", "on_sb3:ppo", None),
    "benchmarl-mappo": ("BenchMARL MAPPO", "on_benchmarl:mappo", "benchmarl"),
    "benchmarl-qmix": ("BenchMARL QMIX", "on_benchmarl:qmix", "benchmarl"),
    "rllib-ppo": ("RLlib PPO", "on_rllib:ppo", "rllib"),
    "skrl-mappo": ("skrl MAPPO", "on_skrl:mappo", "skrl"),
}
"""By name: what tables call it, the function that trains it, and the virtual environment that it needs, if any."""
RESULT = REPOSITORY / "docs" / "peers.json"
COLUMNS = (
    *("Trainer", "Env steps a CPU second", "of ours", "To 95 % success: env steps", "CPU s"),
    *("To 99 % of final U: env steps", "CPU s", "J̄", "R̂ (Mbps)", "T̄ (slots)", "Success (%)", "U (Mbps)"),
)


def table(results: dict[str, Any]) -> str:
    """The peers as a Markdown table.

    :param results: what each left, by name
    :return: the table; a dash where there is nothing
    """
    lines = [f"| {' | '.join(COLUMNS)} |", "|:--" * len(COLUMNS) + "|"]
    for name, (label, *_) in PEERS.items():
        if name not in results:
            continue
        own, row, ours = results[name], results[name]["table_two"], results.get("ours", {})
        speed = own["env_steps_a_cpu_second"]
        share = f"{speed / ours['env_steps_a_cpu_second']:.2f}" if ours else "–"
        cells = [label, f"{speed:,.0f}", share]
        for key in ("to_95_percent_success", "to_99_percent_of_final_utility"):
            found = own[key]
            cells += [f"{found['env_steps']:,.0f}", f"{found['cpu_seconds']:.1f}"] if found else ["–", "–"]
        cells += [f"{row['reward']:.2f}", f"{row['rate_mbps']:.2f}", f"{row['makespan_slots']:.1f}"]
        cells += [f"{row['success_percent']:.1f}", f"{row['utility_mbps']:.1f}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def train(name: str, env_steps: int) -> dict[str, Any]:
    """Train one peer in this process.

    :param name: which of :data:`PEERS`
    :param env_steps: the budget
    :return: what it left
    """
    module, _, function = PEERS[name][1].partition(":")
    found: dict[str, Any] = getattr(importlib.import_module(f"tests.peers.{module}"), function)(env_steps)
    return found


def main() -> None:
    """Train the peers that are asked for, add them to the file, and print the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.peers", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PEERS))
    parser.add_argument("--env-steps", type=int, default=24_576, help="the budget of each")
    parser.add_argument("--out", type=Path, default=RESULT)
    parser.add_argument("--only", metavar="NAME", help=argparse.SUPPRESS)  # in the peer's own environment
    chosen = parser.parse_args()
    if chosen.only:
        write_json(chosen.out, train(chosen.only, chosen.env_steps))
        return
    results = json.loads(chosen.out.read_text(encoding="utf-8")) if chosen.out.exists() else {}
    for name in chosen.names or PEERS:
        venv = PEERS[name][2]
        python = str(REPOSITORY / ".venvs" / venv / "bin" / "python") if venv else sys.executable
        part = chosen.out.with_suffix(f".{name}.part")
        command = [
            python,
            "-m",
            "tests.peers",
            "--only",
            name,
            "--env-steps",
            str(chosen.env_steps),
            "--out",
            str(part),
        ]
        environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(REPOSITORY)}
        done = subprocess.run(command, env=environment, stdout=sys.stderr, check=False)
        if done.returncode:
            print(f"{name} failed with status {done.returncode}; the others go on", file=sys.stderr)
            continue
        found = json.loads(part.read_text(encoding="utf-8"))
        part.unlink()
        results[name] = found | {"python": platform.python_version(), "processor": _processor()}
        write_json(chosen.out, {known: results[known] for known in PEERS if known in results})
    print(table(results))


def _processor() -> str:
    """The processor's name, where the system tells."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor()
    names = (line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name"))
    return next(names, platform.processor())


if __name__ == "__main__":
    main()
