# SPDX-License-Identifier: Zlib
"""Cooks every file of Debian's assimp-testmodels: python3 cook_models.py limber-cook

Each must give a body that can be loaded, or be refused with a reason that names the file; none may crash, hang or
use more memory than the limit. Prints the counts. The exit code is 77 if the models are not installed.
"""
import collections
import concurrent.futures
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

MODELS = pathlib.Path("/usr/share/assimp/models")
MEMORY = 2 << 30  # bytes
SECONDS = 60  # for one file, on a busy machine
# coarse networks and short bracing: only crashes and errors matter here, not the quality
CHOICES = "--points 60 --skin barycentric --seconds 0.2 --runs 0".split()


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(command):
    try:
        done = subprocess.run(command, capture_output=True, preexec_fn=limit, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return "hangs", ""
    return done.returncode, done.stderr.decode(errors="replace").strip()


def cook(tool, model, folder):
    """Returns the outcome ("cooked", "refused" or the fault) and the reason."""
    body = pathlib.Path(folder) / "body.limber"
    code, message = run([tool, str(model), "-o", str(body), "--quiet", *CHOICES])
    if code == 1 and str(model) in message and not body.exists():
        return "refused", message
    if code != 0:
        return f"exit {code}", message
    code, message = run([tool, "--report", str(body), "--quiet", "--runs", "0"])
    return ("cooked", "") if code == 0 else (f"does not load: exit {code}", message)


def outcome(tool, model):
    with tempfile.TemporaryDirectory() as folder:
        return model, *cook(tool, model, folder)


def main(tool):
    if not MODELS.is_dir():
        print(f"no {MODELS}: install assimp-testmodels")
        return 77
    models = sorted(path for path in MODELS.rglob("*") if path.is_file())
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        outcomes = list(pool.map(lambda model: outcome(tool, model), models))
    counts = collections.Counter(result for _, result, _ in outcomes)
    print(", ".join(f"{count} {result}" for result, count in counts.most_common()), f"of {len(models)} files")
    wrong = [o for o in outcomes if o[1] not in ("cooked", "refused")]
    for model, result, message in wrong:
        print(f"{model}: {result}: {message[-300:]}")
    # a tool that refuses everything must not pass
    return 1 if wrong or counts["cooked"] < 200 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
