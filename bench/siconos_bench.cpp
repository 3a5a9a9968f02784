// SPDX-License-Identifier: Apache-2.0

// The contacts of contact_bench.cpp by Siconos (https://nonsmooth.gricad-pages.univ-grenoble-alpes.fr/siconos): its
// nonsmooth Gauss-Seidel for plane friction (fc2d_nsgs_dense) on the same compliance, load path and gap elements, one
// core, fp64. Compiled in where libsiconos_numerics is installed.
#ifdef TACTEL_SICONOS
#include <Friction_cst.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <benchmark/benchmark.h>
#include <fc2d_Solvers.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "bench/random_parabolas.h"
#include "fem/gap/gap_sweep.h"
#include "fem/numbers/cache_directory.h"

namespace {

using namespace tactel;

/// Gap elements of a scene as a problem of Siconos. Velocity = M reaction + q; entries are normal, then tangential, of
/// each contact: reaction n and t, velocity gap and slip. Scenes with one pressing step.
class SiconosContact {
 public:
  /// Gap elements where the surface of the indenter is within 1.25 indentations, as in fem::GapSweep, and at all nodes
  /// that touch in the exact solution: the search for others costs Siconos nothing.
  SiconosContact(const fem::Condensation& condensation, const fem::Scene& scene, const fem::ContactSolution& exact)
      : steps_(fem::load_path(scene.load).steps) {
    const double depth = steps_.front().normal;
    std::vector<int> node;
    for (int i = 0; i < condensation.surface_x.size(); ++i) {
      const double height = fem::profile_height(scene.indenter, condensation.surface_x[i]);
      const bool touches = std::any_of(exact.steps.begin(), exact.steps.end(),
                                       [i](const fem::ContactStep& step) { return step.normal_force[i] > 0; });
      if (height > 1.25 * depth && !touches) continue;
      node.push_back(i);
      height_.push_back(height);
    }
    const auto count = static_cast<Eigen::Index>(node.size());
    const Eigen::MatrixXd& c = condensation.compliance;
    M_.resize(2 * count, 2 * count);
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < count; ++j) {
        const int x = 2 * node[i], y = x + 1, from_x = 2 * node[j], from_y = from_x + 1;
        M_(2 * i, 2 * j) = c(y, from_y);
        M_(2 * i, 2 * j + 1) = -c(y, from_x);
        M_(2 * i + 1, 2 * j) = -c(x, from_y);
        M_(2 * i + 1, 2 * j + 1) = c(x, from_x);
      }
    M_ /= scene.sensor.young;
    mu_.assign(node.size(), scene.friction);
    q_.resize(2 * count);
    reaction_.resize(2 * count);
    velocity_.resize(2 * count);
    const auto size = static_cast<int>(2 * count);
    matrix_.reset(NM_create_from_data(NM_DENSE, size, size, M_.data()));
    problem_ = {2, static_cast<int>(count), matrix_.get(), q_.data(), mu_.data()};
  }

  struct Step {
    double P = 0, Q = 0;  ///< N/mm
    int sweeps = 0;
    bool converged = false;
  };

  /// Goes along the load path, from the reactions of the step before, and calls record(Step) after each.
  template <class Record>
  void solve(SolverOptions* options, const Record& record) {
    reaction_.setZero();
    velocity_.setZero();
    Eigen::VectorXd ux = Eigen::VectorXd::Zero(mu_.size());  // displacement of the last step
    double x_last = 0;
    for (const fem::LoadStep& step : steps_) {
      for (std::size_t i = 0; i < mu_.size(); ++i) {
        q_[2 * i] = height_[i] - step.normal;
        q_[2 * i + 1] = -(ux[i] + step.tangential - x_last);
      }
      int failed = 0;
      fc2d_nsgs_dense(&problem_, reaction_.data(), velocity_.data(), &failed, options);
      ux = (M_ * reaction_)(Eigen::seq(1, Eigen::last, 2));
      x_last = step.tangential;
      record(Step{reaction_(Eigen::seq(0, Eigen::last, 2)).sum(), reaction_(Eigen::seq(1, Eigen::last, 2)).sum(),
                  options->iparam[SICONOS_IPARAM_ITER_DONE], failed == 0});
    }
  }

 private:
  struct Free {
    void operator()(NumericsMatrix* matrix) const {  // the numbers are M_'s
      matrix->matrix0 = nullptr;
      NM_free(matrix);
    }
  };

  std::vector<fem::LoadStep> steps_;
  std::vector<double> height_, mu_;          ///< [contacts] mm; friction
  Eigen::MatrixXd M_;                        ///< [2 contacts, 2 contacts] mm/(N/mm)
  Eigen::VectorXd q_, reaction_, velocity_;  ///< [2 contacts] mm, N/mm, mm
  std::unique_ptr<NumericsMatrix, Free> matrix_;
  FrictionContactProblem problem_{};
};

/// Tolerance: the residual of Siconos' complementarity problem over |q|.
void siconos(benchmark::State& state, char which, double tolerance) {
  const fem::Condensation condensation = fem::condense_cached(bench::mesh(which), fem::default_cache_directory());
  const fem::GapSweep<double> twin(condensation);
  const auto scenes = bench::random_parabolas(bench::mesh(which), 64);
  const std::unique_ptr<SolverOptions, void (*)(SolverOptions*)> options(
      solver_options_create(SICONOS_FRICTION_2D_NSGS), solver_options_delete);
  options->dparam[SICONOS_DPARAM_TOL] = tolerance;
  options->iparam[SICONOS_IPARAM_MAX_ITER] = 20000;
  std::vector<SiconosContact> contacts;
  double worst = 0, sweeps = 0, steps = 0;
  for (const fem::Scene& scene : scenes) {
    const fem::ContactSolution exact = twin.solve(scene);
    contacts.emplace_back(condensation, scene, exact);
    auto expected = exact.steps.begin();
    contacts.back().solve(options.get(), [&](const SiconosContact::Step& step) {
      worst = std::max(worst, bench::difference(scene.friction, step, *expected));
      if (!step.converged) worst = std::numeric_limits<double>::infinity();
      sweeps += step.iterations;
      steps += 1;
      ++expected;
    });
  }
  // It stops at its tolerance; what it then lacks is of the same order: 2e-4 on mesh B, 3e-4 on mesh A, tenfold less at
  // a tenth of the tolerance.
  if (!(worst <= 10 * tolerance)) return state.SkipWithError("P, Q or S differ from the Eigen twin's");
  std::size_t next = 0;
  for (auto _ : state) {
    double Q = 0;
    contacts[next++ % contacts.size()].solve(options.get(), [&](const SiconosContact::Step& step) { Q = step.Q; });
    benchmark::DoNotOptimize(Q);
  }
  state.counters["steps_per_second"] = benchmark::Counter(8, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["sweeps"] = sweeps / steps;
  state.counters["worst_off"] = worst;
}

const bool siconos_registered = [] {
  const auto add = [](const char* name, auto body) {
    benchmark::RegisterBenchmark(name, body)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  add("contact/mesh_B/siconos_fp64", [](benchmark::State& state) { siconos(state, 'B', 1e-4); });
  add("contact/mesh_A/siconos_fp64", [](benchmark::State& state) { siconos(state, 'A', 1e-4); });
  return true;
}();

}  // namespace
#endif
