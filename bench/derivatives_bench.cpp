// SPDX-License-Identifier: Apache-2.0

// Derivatives of a load path beside its solve: one press and eight drags on a patch of 12 elements, or on mesh A.
#include <benchmark/benchmark.h>

#include <stdexcept>

#include "fem/gap_condensed.h"
#include "fem/gap_reference.h"
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

/// The twin's solve at the default tolerance of a rung, at that of `solve`, and to rounding, as derivatives need it.
void solve(benchmark::State& state, const PatchOptions& options) {
  Case& c = shared();
  for (auto _ : state) benchmark::DoNotOptimize(PatchSolver(c.model, options).solve(c.scene));
}
BENCHMARK_CAPTURE(solve, loose, {.tolerance = 1e-3})->Name("derivatives/solve_1e-3")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, tight, {.tolerance = 1e-7})->Name("derivatives/solve_1e-7")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve, exact, exact_sweeps({}))->Name("derivatives/solve_exact")->Unit(benchmark::kMicrosecond);

/// The same scene on mesh A.
struct MeshCase {
  Scene scene = [] {
    Scene on_mesh = shared().scene;
    on_mesh.model = SurfaceModel::mesh;
    return on_mesh;
  }();
  Condensation rubber = condense_cached(scene.sensor, default_cache_directory());
  SceneDerivatives derivatives = mesh_derivatives(scene);
};

MeshCase& on_mesh() {
  static MeshCase made;
  return made;
}

/// The exact solve of the condensed mesh: active sets, fp64.
void mesh_solve(benchmark::State& state) {
  const GapCondensed solver(on_mesh().rubber);
  for (auto _ : state) benchmark::DoNotOptimize(solver.solve(on_mesh().scene));
}
BENCHMARK(mesh_solve)->Name("derivatives/mesh_solve")->Unit(benchmark::kMicrosecond);

/// The full mesh, `solve --solver reference`.
void reference_solve(benchmark::State& state) {
  GapReference reference(on_mesh().scene.sensor);
  for (auto _ : state) benchmark::DoNotOptimize(reference.solve(on_mesh().scene));
}
BENCHMARK(reference_solve)->Name("derivatives/reference_solve")->Unit(benchmark::kMicrosecond);

/// The path solved again with its statuses, and its derivatives by all parameters.
void time_path(benchmark::State& state, const SceneDerivatives& d) {
  for (auto _ : state) {
    const PathDerivatives path(d.path.path());
    for (const PathDirection& direction : d.directions) benchmark::DoNotOptimize(path.forward(direction));
  }
}
void patch_path(benchmark::State& state) { time_path(state, shared().derivatives()); }
BENCHMARK(patch_path)->Name("derivatives/patch")->Unit(benchmark::kMicrosecond);
void mesh_path(benchmark::State& state) { time_path(state, on_mesh().derivatives); }
BENCHMARK(mesh_path)->Name("derivatives/mesh")->Unit(benchmark::kMicrosecond);

}  // namespace
