#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes 27 mistakes, one after the other, each of which a test of scripts/test must find: mutants.py [NUMBER...]

The mistakes are in kernels, their twins and readers of files. Each is put into the source, what it takes is built in build/, the tests
that should find it run, and the source is put back. Ends with 1 where a mistake was not found, or its place in the source is gone."""
import pathlib
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# file, what stands there, the mistake, targets, tests (a regular expression for ctest -R)
MUTANTS = [
    ("kernels/gap_sweep.cl", "SMALLER(LARGER(t_free, -cone), cone), t_old)", "LARGER(t_free, -cone), t_old)", "contact", "Ragged.*Fp64MatchesTwin/17"),
    ("kernels/gap_sweep.cl", "k->drift[v] = LARGER(drift, k->drift[v]);", "k->drift[v] = drift;", "contact", "Certificate.IsThatOfTheWrittenForces"),
    ("kernels/patch/compliance.h", "yx = -rows.xy[i - j];", "yx = rows.xy[i - j];", "contact", "PatchContact/Twin.Fp64MatchesIt/12"),
    ("kernels/patch/base_stress.h", "t0 = LOAD(here + to->outputs);", "t0 = LOAD(here);", "contact", "PatchContact/Twin.Fp64MatchesIt/12"),
    ("kernels/pad/cells.h", "x->v[v] = s.xx.v[v] + s.xy.v[v] - s.xn.v[v];", "x->v[v] = s.xx.v[v] + s.xy.v[v] + s.xn.v[v];", "contact",
     "PadContact.NamedScenesInFp64"),
    ("kernels/pad/sweep.h", "const vint slips = q > cone * cone;", "const vint slips = q < 0;", "contact", "PadContact.NamedScenesInFp64"),
    ("kernels/forward.cl", "o[2] = o[0] - o[2];", "o[2] = o[0] + o[2];", "networks", "ForwardHeads.MatchTheReference"),
    ("kernels/forward.cl", "largest < ALL_LANES(SMALLEST_STRESS);", "largest < ALL_LANES(0);", "networks",
     "ForwardTest.NeverAnswersNaN"),
    ("kernels/train_online.cl", "momentum, (real)1);", "momentum, momentum);", "networks", "TrainOnlineTest.Fp64.*/\"1\""),
    ("kernels/shared/batch_rule.h", "(o[2] + (real)0.5), 1 - level);", "(o[2] + (real)0.5), level);", "networks", "TrainBatchGradient.OfQuantiles"),
    ("kernels/transducer_chain.cl", "    y += offset;\n", "", "sets", "TransducerChannels.MatchesTwin"),
    ("kernels/transducer_chain.cl", "if (k > 0) y = PICK", "y = PICK", "sets", "TransducerChannels.SkinsMatchTwin"),
    ("kernels/shared/philox.h", "key1 += 0xBB67AE85u;", "key1 += 0xBB67AE86u;", "sets", "TransducerChannels.MatchesTwin"),
    ("fem/gap/gap_sweep.cpp", "static_cast<Real>(c(2 * i + 1, 2 * j));", "static_cast<Real>(-c(2 * i + 1, 2 * j));", "contact", "Ragged.*Fp64MatchesTwin/17"),
    ("fem/layer/patch_contact.cpp", "(x - x_last_) : now[i];", "(x - x_last_) : ux_last_[i];", "layer", "PatchSolver|PatchShapes|PatchClosedForms"),
    ("fem/pad/pad_search.cpp", "indenter.yaw += indenter.tilt_direction;", "indenter.yaw -= indenter.tilt_direction;", "pad",
     "PadLayout.ATiltedPunchMayBeTurned"),
    ("fem/pad/slip_margin.cpp", "wrench[2] - (centre[0]", "wrench[2] + (centre[0]", "pad", "SlipMargin.DoesNotDependOnThePoint"),
    ("nn/train_batch.cpp", "std::pow(options.beta2, t)", "std::pow(options.beta2, 2 * t)", "nn", "TrainBatch.AdamsFirstStep"),
    ("nn/train_online.cpp", "step *= Scalar(options.momentum);", "step *= Scalar(options.rate);", "nn", "TrainOnline.FollowsTheRule"),
    ("nn/transducer_chain.cpp", "std::clamp(code, -half, half - 1)", "std::clamp(code, -half, half)", "nn", "Transducer.ConvertsByHand"),
    ("hw/decoder.cpp", "counts_.lost += ahead - 1;", "counts_.lost += ahead;", "hw", "EveryFormat.GoesOnAfterAnInterruption"),
    ("host/live/csv_source.cpp", "if (!live_) throw", "throw", "live", "CsvPipe.ABadLineCountsAndTheNextIsAFrame"),
    ("hw/recording.cpp", "if (crc32(Bytes(record).first(end)) != unsigned_at(record, end, 4))", "if (false)", "hw", "Recording.DamageIsFound"),
    ("host/scenes/profile_csv.cpp", "point[0] <= profile.x.back()", "point[0] < profile.x.back()", "commands", "BadScene.*Csv"),
    ("host/scenes/pad_file.cpp", "radians(twists[k])", "twists[k]", "scenes", "PadFile.EveryKey"),
    ("host/scenes/toml_table.cpp", "refuse_unknown({asked_.begin(), asked_.end()});", "", "commands", "BadSceneTest.*/(Misspelt|Unknown)Key"),
    ("host/sets/check_set.cpp", "if (in_.text(seal_name) != in_.seal())", "if (false)", "sets", "CheckSet.FindsEveryEdit"),
]


def build(room):
    program = ["tactel"] if room == "commands" else []
    command = ["cmake", "--build", "build", "--target", f"tactel_{room}_tests", *program]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def passes(tests):
    """Whether these tests of scripts/test pass; there must be some."""
    command = ["ctest", "--preset", "release", "-R", tests, "--no-tests=error"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if "No tests were found" in done.stdout + done.stderr:
        sys.exit(f"no test of scripts/test is called {tests}")
    return done.returncode == 0


def found(file, right, wrong, room, tests):
    path = ROOT / file
    text = path.read_text()
    if text.count(right) != 1:
        return f"{text.count(right)} places hold `{right}`; adapt tests/mutants.py"
    path.write_text(text.replace(right, wrong))
    try:
        if (built := build(room)).returncode != 0:
            return "does not compile:\n" + built.stdout[-2000:]
        return "not found by any test" if passes(tests) else ""
    finally:
        path.write_text(text)


def main(numbers):
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # `finally` puts the source back
    chosen = numbers or range(1, len(MUTANTS) + 1)
    failed, rooms = 0, {MUTANTS[number - 1][3] for number in chosen}
    for number in chosen:
        problem = found(*MUTANTS[number - 1])
        failed += bool(problem)
        print(f"{number:2} {MUTANTS[number - 1][0]}: {problem or 'found'}", flush=True)
    for room in rooms:
        build(room)
    right = passes("|".join(MUTANTS[number - 1][4] for number in chosen))
    print("the tests pass without a mistake" if right else "some of the tests fail without a mistake, too")
    return int(failed > 0 or not right)


if __name__ == "__main__":
    sys.exit(main([int(text) for text in sys.argv[1:]]))
