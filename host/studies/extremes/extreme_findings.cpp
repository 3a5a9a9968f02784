// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fem/gap/gap_reference.h"
#include "fem/numbers/value_error.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/studies/extremes/extremes.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::host {
namespace {

/// Numbers of LaneResultRow alone: paths of 90 000 increments would fill memory with forces that are never read.
constexpr GapSweepOptions results_only{.base_forces = false, .tactels = false, .nodes = false};

template <class Real>
typename GapSweep<Real>::Batch run_alone(Executor& executor, const fem::Scene& scene) {
  auto batch = GapSweep<Real>(executor, scene.sensor, results_only).prepare(std::span(&scene, 1));
  batch.run();
  return batch;
}

template <class Batch>
bool all_solved(const Batch& batch) {
  for (int k = 0; k < batch.steps(); ++k)
    if (static_cast<int>(batch.result(0, k, RESULT_STATUS)) >= LANE_UNSOLVED) return false;
  return true;
}

template <class Batch>
ForcePath force_path(const Batch& batch) {
  ForcePath path;
  for (int k = 0; k < batch.steps(); ++k) {
    path.P.push_back(batch.result(0, k, RESULT_P));
    path.Q.push_back(batch.result(0, k, LANE_Q));
  }
  return path;
}

/// A loop of drag, forth and back again and again: after ten rounds Q must come back to where it was at each end.
template <class Real>
ExtremeFinding reversals(Executor& executor, int count) {
  fem::Scene scene = ordinary_scene();
  scene.load.tangential.clear();
  for (int k = 0; k < count; ++k) scene.load.tangential.push_back(k % 2 ? -0.15 : 0.15);
  const auto batch = run_alone<Real>(executor, scene);
  const double drift = loop_drift(force_path(batch), 21);
  const bool fp32 = sizeof(Real) == 4, solved = all_solved(batch);
  return {fmt::format("{} reversals, {}: does the same loop close?", count, fp32 ? "fp32" : "fp64"),
          fmt::format("P and Q at the ends within {:.1e} of P{}", drift, solved ? "" : ", NOT converged"),
          solved && drift <= (fp32 ? 1e-4 : 1e-10)};  // ten times what a sweep may still change
}

/// Held in mid-drag by a hand that trembles: a jiggle of a few roundings of the position makes every increment iterate
/// (at rest lanes do not). After the first round P and Q at either end must not creep.
template <class Real>
ExtremeFinding holding(Executor& executor, double drag, int count) {
  constexpr bool fp32 = sizeof(Real) == 4;
  constexpr double jiggle = fp32 ? 1e-7 : 1e-9;  // mm; fp32 resolves 1.5e-8 there
  fem::Scene scene = ordinary_scene();
  scene.load.tangential.clear();
  for (int k = 0; k <= count; ++k) scene.load.tangential.push_back(k % 2 ? drag + jiggle : drag);
  const auto batch = run_alone<Real>(executor, scene);
  const double creep = loop_drift(force_path(batch), 2);
  int iterated = 0;
  for (int k = 2; k < batch.steps(); ++k) iterated += batch.result(0, k, RESULT_SWEEPS) > 0;
  return {fmt::format("held at S = {:.3f}, {:g} mm to and fro {} times, {}: does it creep?",
                      batch.result(0, 1, RESULT_S), jiggle, count, fp32 ? "fp32" : "fp64"),
          fmt::format("P and Q by {:.1e} of P; {} increments iterated", creep, iterated),
          creep <= (fp32 ? 1e-4 : 1e-10) && 10 * iterated > 9 * count && all_solved(batch)};
}

std::vector<fem::Scene> drags(double mu, int count) {
  std::mt19937_64 random(1998);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937_64::max());
  };
  std::vector<fem::Scene> scenes(count, ordinary_scene());
  for (fem::Scene& scene : scenes) {
    scene.friction = mu;
    scene.indenter.shape = fem::Parabola{std::exp(uniform(1, 5))};
    scene.indenter.position = uniform(-3, 3);
    scene.load.indentation = {uniform(0.05, 0.25)};
    scene.load.tangential = {uniform(-0.3, 0.3), uniform(-0.3, 0.3), uniform(-0.3, 0.3)};
  }
  return scenes;
}

bool solved(const fem::ContactSolution& solution) { return solution.steps.back().converged; }

/// Beyond mu of about 3 Coulomb's problem may have several solutions: sweeps and status iteration, which start
/// differently, may then end in different ones, each with a certificate.
ExtremeFinding several_solutions(Executor& executor, double mu, int count) {
  const auto scenes = drags(mu, count);
  const auto sweeps = solve_on_meshes(executor, scenes, Precision::fp64);
  fem::GapReference reference(scenes.front().sensor);
  int unsolved = 0, fell_back = 0, different = 0;
  for (int i = 0; i < count; ++i) {
    const auto other = reference.solve(scenes[i]);
    fell_back += sweeps[i].fell_back;
    unsolved += !solved(sweeps[i]) || !solved(other);
    const double P = other.steps.back().P, Q = other.steps.back().Q;
    const double off = std::abs(sweeps[i].steps.back().P - P) + std::abs(sweeps[i].steps.back().Q - Q);
    different += solved(sweeps[i]) && solved(other) && off > 1e-6 * (std::abs(P) + std::abs(Q));
  }
  return {
      fmt::format("mu = {:g}, {} random drags: one solution?", mu, count),
      fmt::format("{} with two certified solutions; {} by the fallback, {} unsolved", different, fell_back, unsolved),
      unsolved == 0 && (mu > 3 || different == 0)};
}

ExtremeFinding refused(const std::string& what, void (*change)(fem::Scene&)) {
  fem::Scene scene = ordinary_scene();
  change(scene);
  try {
    scene.validate();
  } catch (const ValueError& error) {
    return {what + "?", std::string("exit 2: ") + error.what(), true};
  }
  return {what + "?", "ACCEPTED", false};
}

}  // namespace

double loop_drift(const ForcePath& path, std::size_t first) {
  double drift = 0;
  for (std::size_t k = first; k < path.P.size(); ++k) {
    const std::size_t same = first + (k - first) % 2;
    for (const double off : {path.P[k] - path.P[same], path.Q[k] - path.Q[same]}) {
      if (std::isnan(off)) return off;
      drift = std::max(drift, std::abs(off));
    }
  }
  return drift / path.P[first];
}

std::vector<ExtremeFinding> extreme_findings(Executor& executor, bool quick) {
  const int turns = quick ? 300 : 10000, holds = quick ? 1000 : 90000, scenes = quick ? 40 : 500;
  std::vector<ExtremeFinding> found = {reversals<float>(executor, turns), reversals<double>(executor, turns)};
  for (double drag : {0.1148, 0.236}) {
    found.push_back(holding<float>(executor, drag, holds));
    found.push_back(holding<double>(executor, drag, holds));
  }
  for (double mu : {1.0, 3.0, 10.0, 30.0, 100.0}) found.push_back(several_solutions(executor, mu, scenes));
  found.push_back(refused("nu = 0.5", [](fem::Scene& s) { s.sensor.poisson = 0.5; }));
  found.push_back(refused("mu = -0.1", [](fem::Scene& s) { s.friction = -0.1; }));
  found.push_back(refused("a mesh of 2 x 2", [](fem::Scene& s) { s.sensor.columns = s.sensor.rows = 2; }));
  found.push_back(refused("the indenter beside the sensor", [](fem::Scene& s) { s.indenter.position = 11; }));
  found.push_back(refused("no node under the indenter", [](fem::Scene& s) { s.indenter = {fem::Flat{0.1}, 0.25}; }));
  found.push_back(refused("an angle beyond friction", [](fem::Scene& s) {
    s.load.indentation.clear(), s.load.tangential.clear();
    s.load.normal_force = {1}, s.load.angle = 30;
  }));
  return found;
}

std::string findings_table(const std::vector<ExtremeFinding>& findings) {
  std::string out;
  for (const ExtremeFinding& f : findings)
    out += fmt::format("{} {:<62} {}\n", f.good ? " " : "!", f.question, f.found);
  return out;
}

}  // namespace tactel::host
