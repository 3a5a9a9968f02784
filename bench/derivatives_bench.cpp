// SPDX-License-Identifier: Apache-2.0

// Derivatives of a load path beside its solve: one press and eight drags on a patch of 12 elements, eleven parameters.
#include <benchmark/benchmark.h>

#include <stdexcept>

#include "fem/layer/patch_derivatives.h"

namespace {

using namespace tactel::fem;

struct Case {
  LayerModel model = endless_layer({});
  LayerDerivatives layer{model};
  Scene scene;
  PatchTrace trace;

  Case() {
    scene.indenter = {Parabola{10}, 0.3};
    scene.load.tangential_step = 0.02;
    scene.load.tangential_steps = 8;
    PatchSolver(model, exact_sweeps({})).solve(scene, &trace);
    layer.by_poisson(trace.patch);  // tables of the sensor, once for all its contacts
    const SceneDerivatives d = derivatives();
    if (d.path.answers().size() != 9 || !(d.path.answers().back().P > 0))
      throw std::runtime_error("derivatives: no answer to differentiate");
  }
  SceneDerivatives derivatives() { return patch_derivatives(model, layer, scene, trace, {}); }
};

Case& shared() {
  static Case made;
  return made;
}

/// The twin's solve at the default tolerance of a rung, at that of `solve`, and to rounding.
void solve(benchmark::State& state, double tolerance) {
  Case& c = shared();
  for (auto _ : state) benchmark::DoNotOptimize(PatchSolver(c.model, {.tolerance = tolerance}).solve(c.scene));
}
BENCHMARK_CAPTURE(solve, loose, 1e-3)->Name("derivatives/solve_1e-3")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, tight, 1e-7)->Name("derivatives/solve_1e-7")->Unit(benchmark::kMicrosecond);

/// The path solved again with its statuses, and one gradient of S by all parameters.
void gradient(benchmark::State& state) {
  Case& c = shared();
  const SceneDerivatives d = c.derivatives();
  std::vector<PathWeights> weights(9);
  weights.back().S = 1;
  for (auto _ : state) {
    const PathDerivatives path(d.path.path());
    const PathDirection gradient = path.adjoint(weights);
    double sum = 0;
    for (const PathDirection& direction : d.directions) sum += along(gradient, direction);
    benchmark::DoNotOptimize(sum);
  }
}
BENCHMARK(gradient)->Name("derivatives/gradient")->Unit(benchmark::kMicrosecond);

/// The same by one direction, forward.
void forward(benchmark::State& state) {
  Case& c = shared();
  const SceneDerivatives d = c.derivatives();
  for (auto _ : state) benchmark::DoNotOptimize(d.path.forward(d.directions.front()));
}
BENCHMARK(forward)->Name("derivatives/forward")->Unit(benchmark::kMicrosecond);

}  // namespace
