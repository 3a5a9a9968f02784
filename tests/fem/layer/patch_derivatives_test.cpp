// SPDX-License-Identifier: Apache-2.0

// Derivatives of a load path on a patch against central differences of the sweeps, which know nothing of them; closed
// forms.
#include "fem/layer/patch_derivatives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "layer_sensors.h"

namespace tactel::fem {
namespace {

/// All outputs of a path, a column each: P, Q, S over the steps, and all frames.
std::vector<Eigen::VectorXd> outputs(const ContactSolution& solution) {
  const auto steps = static_cast<Eigen::Index>(solution.steps.size());
  const Eigen::Index tactels = solution.tactel_x.size();
  Eigen::VectorXd P(steps), Q(steps), S(steps), frames(2 * tactels * steps);
  for (Eigen::Index k = 0; k < steps; ++k) {
    const ContactStep& step = solution.steps[static_cast<std::size_t>(k)];
    P[k] = step.P, Q[k] = step.Q, S[k] = step.slip_index.value_or(0);
    frames.segment(2 * tactels * k, 2 * tactels) << step.sigma_y, step.tau_xy;
  }
  return {P, Q, S, frames};
}

std::vector<Eigen::VectorXd> outputs(const std::vector<PathAnswer>& answers) {
  const auto steps = static_cast<Eigen::Index>(answers.size());
  const Eigen::Index frame = answers.front().frame.size();
  Eigen::VectorXd P(steps), Q(steps), S(steps), frames(frame * steps);
  for (Eigen::Index k = 0; k < steps; ++k) {
    const PathAnswer& a = answers[static_cast<std::size_t>(k)];
    P[k] = a.P, Q[k] = a.Q, S[k] = a.S.value_or(0);
    frames.segment(frame * k, frame) = a.frame;
  }
  return {P, Q, S, frames};
}

/// Largest difference of two derivatives over the largest of its output; an output of which the derivative is less
/// than 0.001 of its value over the parameter's counts as that much.
double difference(const std::vector<Eigen::VectorXd>& derivative, const std::vector<Eigen::VectorXd>& by_differences,
                  const std::vector<Eigen::VectorXd>& values, double parameter) {
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double scale =
        std::max(by_differences[i].cwiseAbs().maxCoeff(), 1e-3 * values[i].cwiseAbs().maxCoeff() / parameter);
    if (scale > 0) worst = std::max(worst, (derivative[i] - by_differences[i]).cwiseAbs().maxCoeff() / scale);
  }
  return worst;
}

using Change = std::function<void(Scene&, Patch&, double)>;

struct PathCase {
  Scene scene;
  std::string name;  ///< of the parameter
  double size;       ///< of the parameter, for steps
  Change change;
};

struct Number {
  std::string name;
  Change change;
};

template <class Kind>
Change of_shape(double Kind::*number) {
  return [=](Scene& scene, Patch&, double by) { std::get<Kind>(scene.indenter.shape).*number += by; };
}

class RandomPaths {
 public:
  PathCase draw() {
    const LayerModel& model = endless(nu[pick(3)]);
    const double depth = between(0.03, 0.25), mu = between(0.1, 1.2), position = between(-5, 5);
    Load load{.indentation = {depth}};
    double x = 0;
    for (int k = 0; k < 4; ++k) load.tangential.push_back(x += between(-0.2, 0.6) * mu * depth);
    Shape shape;
    std::vector<Number> own;
    own.reserve(8);
    switch (pick(6)) {
      case 0:
        shape = Parabola{between(2, 40)};
        own.push_back({"indenter.radius", of_shape(&Parabola::radius)});
        break;
      case 1:
        shape = Wedge{between(120, 172)};
        own.push_back({"indenter.edge_angle", of_shape(&Wedge::edge_angle)});
        break;
      case 2:
        shape = Cylinder{between(3, 30)};
        own.push_back({"indenter.radius", of_shape(&Cylinder::radius)});
        break;
      case 3:
        shape = Exponential{between(0.02, 0.3), between(0.3, 1.5)};
        own.push_back({"indenter.height", of_shape(&Exponential::height)});
        own.push_back({"indenter.rate", of_shape(&Exponential::rate)});
        break;
      case 4:
        shape = RoundedFlat{between(0.3, 2), between(2, 20)};
        own.push_back({"indenter.half_width", of_shape(&RoundedFlat::half_width)});
        own.push_back({"indenter.radius", of_shape(&RoundedFlat::radius)});
        break;
      default:
        shape = Flat{between(0.5, 3)};
        own.push_back({"indenter.half_width", [position](Scene& s, Patch& patch, double by) {
                         double& half = *std::get<Flat>(s.indenter.shape).half_width;
                         const double factor = (half + by) / half;
                         half += by;
                         patch.left = position + (patch.left - position) * factor;
                         patch.right = position + (patch.right - position) * factor;
                       }});
    }
    PathCase c{scene_on(model, shape, position, mu, load), {}, 1, {}};
    own.push_back({"contact.friction", [](Scene& s, Patch&, double by) { s.friction += by; }});
    own.push_back({"sensor.young", [](Scene& s, Patch&, double by) { s.sensor.young += by; }});
    own.push_back({"load.indentation", [](Scene& s, Patch&, double by) { s.load.indentation[0] += by; }});
    own.push_back({"load.tangential[1]", [](Scene& s, Patch&, double by) { s.load.tangential[1] += by; }});
    own.push_back({"indenter.position", [](Scene& s, Patch& patch, double by) {
                     s.indenter.position += by;
                     patch.left += by;
                     patch.right += by;
                   }});
    Number& number = own[pick(own.size())];
    c.name = number.name;
    c.change = number.change;
    return c;
  }

 private:
  static constexpr double nu[] = {0.3, 0.45, 0.49};
  std::size_t pick(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_); }
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  std::mt19937 random_{15};
};

std::size_t index_of(const SceneDerivatives& derivatives, const std::string& name) {
  const auto found = std::ranges::find(derivatives.parameters, name, &SceneParameter::name);
  EXPECT_NE(found, derivatives.parameters.end()) << name;
  return static_cast<std::size_t>(found - derivatives.parameters.begin());
}

/// The derivatives of all outputs by a parameter.
std::vector<Eigen::VectorXd> derivative(const SceneDerivatives& d, const std::string& name) {
  return outputs(d.path.forward(d.directions[index_of(d, name)]));
}

/// The central difference of `at` about 0, over twice `size`.
template <class Outputs>
std::vector<Eigen::VectorXd> central_difference(const Outputs& at, double step, double size) {
  std::vector<Eigen::VectorXd> plus = at(step);
  const std::vector<Eigen::VectorXd> minus = at(-step);
  for (std::size_t i = 0; i < plus.size(); ++i) plus[i] = (plus[i] - minus[i]) / (2 * size);
  return plus;
}

std::vector<Eigen::VectorXd> by_differences(const PathCase& c, const Patch& patch, double step) {
  const LayerModel& model = endless(c.scene.sensor.poisson);
  const PatchSolver solver(model, exact_sweeps({}));
  const auto at = [&](double by) {
    Scene scene = c.scene;
    Patch moved = patch;
    c.change(scene, moved, by);
    return outputs(solver.solve_on(moved, scene));
  };
  return central_difference(at, step, step);
}

/// Best agreement over a ladder of steps: their error falls with order 2 until rounding ends it.
double ladder(const PathCase& c, const Patch& patch, const std::vector<Eigen::VectorXd>& derivative,
              const std::vector<Eigen::VectorXd>& values, double size) {
  double best = 1;
  for (const double step : {1e-4, 1e-5, 1e-6, 1e-7})
    best = std::min(best, difference(derivative, by_differences(c, patch, step * size), values, size));
  return best;
}

TEST(PatchDerivatives, AgreeWithCentralDifferencesOnRandomPaths) {
  RandomPaths random;
  std::map<double, std::unique_ptr<LayerDerivatives>> layers;
  int compared = 0, across = 0;
  for (int k = 0; k < 1000; ++k) {
    SCOPED_TRACE(k);
    const PathCase c = random.draw();
    const LayerModel& model = endless(c.scene.sensor.poisson);
    auto& layer = layers[c.scene.sensor.poisson];
    if (!layer) layer = std::make_unique<LayerDerivatives>(model);
    PatchTrace trace;
    const ContactSolution solution = PatchSolver(model, exact_sweeps({})).solve(c.scene, &trace);
    const SceneDerivatives d = patch_derivatives(model, *layer, c.scene, trace, {});
    EXPECT_LE(difference(outputs(d.path.answers()), outputs(solution), outputs(solution), 1e-3), 1e-11)
        << k;  // what a tolerance of 1e-13 leaves where sweeps converge slowly
    if (d.path.answers().back().distance_to_switch < 1e-6) continue;
    const std::size_t i = index_of(d, c.name);
    const double size = std::max(0.1, std::abs(d.parameters[i].value));
    const double error = ladder(c, trace.patch, outputs(d.path.forward(d.directions[i])), outputs(solution), size);
    // Elements that move may cross a row of the table of base stress, between which it is linear.
    const bool moves = c.name == "indenter.position" || c.name == "indenter.half_width";
    across += moves && error > 1e-6;
    EXPECT_LE(error, moves ? 1e-5 : 1e-6)
        << "path " << k << ", " << shape_name(c.scene.indenter.shape) << ", " << c.name;
    ++compared;
  }
  EXPECT_GT(compared, 990);
  EXPECT_LE(across, 3);  // rare: some 230 paths move, and an element must be as near to a row as the smallest steps
}

/// A path with several targets, drags and a way back, by depth or by force.
std::vector<Load> histories() {
  Load depths, forces, angle;
  depths.indentation = {0.12, 0.05, 0.15};
  depths.indentation_steps = 2;
  depths.tangential = {0.03, 0.08, 0.02};
  forces.indentation.clear();
  forces.normal_force = {0.4};
  forces.indentation_steps = 2;
  forces.tangential = {0.03, 0.05, -0.02};
  angle.indentation.clear();
  angle.normal_force = {0.6};
  angle.indentation_steps = 3;
  angle.angle = 12;
  return {depths, forces, angle};
}

TEST(PatchDerivatives, GivenForcesAndSeveralTargets) {
  const LayerModel& model = endless(0.45);
  LayerDerivatives layer(model);
  for (const Load& load : histories()) {
    PathCase c{scene_on(model, Parabola{8}, 0.7, 0.6, load), {}, 1, {}};
    PatchTrace trace;
    const ContactSolution solution = PatchSolver(model, exact_sweeps({})).solve(c.scene, &trace);
    const SceneDerivatives d = patch_derivatives(model, layer, c.scene, trace, {});
    const auto compare = [&](const std::string& name, const Change& change) {
      c.change = change;
      // A force is searched to 1e-14 of it, a length to rounding.
      EXPECT_LE(ladder(c, trace.patch, derivative(d, name), outputs(solution), 1), 1e-6) << name;
    };
    compare("contact.friction", [](Scene& s, Patch&, double by) { s.friction += by; });
    compare("sensor.young", [](Scene& s, Patch&, double by) { s.sensor.young += by; });
    compare("indenter.radius", of_shape(&Parabola::radius));
    if (load.angle) compare("load.angle", [](Scene& s, Patch&, double by) { *s.load.angle += by; });
    if (!load.normal_force.empty())
      compare("load.normal_force", [](Scene& s, Patch&, double by) { s.load.normal_force[0] += by; });
    else
      compare("load.indentation[1]", [](Scene& s, Patch&, double by) { s.load.indentation[1] += by; });
  }
}

TEST(PatchDerivatives, PoissonAndThickness) {
  const double nu = 0.4, h = 1.5;
  const auto model_of = [](double poisson, double thickness) {
    Sensor sensor;
    sensor.length = 19.725;  // rows of the table of base stress are as many for all thicknesses below
    sensor.poisson = poisson;
    sensor.thickness = thickness;
    return endless_layer(sensor);
  };
  const LayerModel model = model_of(nu, h);
  LayerDerivatives layer(model);
  const Scene scene = scene_on(model, Parabola{12}, 1.3, 0.5, {.tangential = {0.03, 0.06, 0.02}});
  PatchTrace trace;
  const ContactSolution solution = PatchSolver(model, exact_sweeps({})).solve(scene, &trace);
  const SceneDerivatives d = patch_derivatives(model, layer, scene, trace, {});
  const auto error = [&](const char* name, double step, double dnu, double dh) {
    const auto at = [&](double by) {
      const LayerModel moved = model_of(nu + by * dnu, h + by * dh);
      Scene own = scene;
      own.sensor = moved.sensor;
      return outputs(PatchSolver(moved, exact_sweeps({})).solve_on(trace.patch, own));
    };
    return difference(derivative(d, name), central_difference(at, step, step), outputs(solution), 1);
  };
  for (const auto& [name, dnu, dh] : {std::tuple{"sensor.poisson", 1.0, 0.0}, {"sensor.thickness", 0.0, 1.0}}) {
    const double coarse = error(name, 1.6e-3, dnu, dh), fine = error(name, 4e-4, dnu, dh);
    EXPECT_NEAR(coarse / fine, 16, 1) << name;  // order 2
    EXPECT_LE(error(name, 1e-5, dnu, dh), 1e-6) << name;
  }
}

/// Near an end of the sensor the free sides count. Their part is a central difference: neighbours at other steps agree
/// with it to that step's square.
TEST(PatchDerivatives, FreeSides) {
  Sensor sensor;
  sensor.length = 9.03;  // rows of tables are as many for all thicknesses below
  sensor.poisson = 0.4;
  const LayerModel model = layer_model(sensor);
  LayerDerivatives layer(model);
  const Scene scene = scene_on(model, Parabola{6}, -3.2, 0.5, {.indentation = {0.1}, .tangential = {0.03, 0.06}});
  PatchTrace trace;
  const ContactSolution solution = PatchSolver(model, exact_sweeps({})).solve(scene, &trace);
  const SceneDerivatives d = patch_derivatives(model, layer, scene, trace, {});
  const auto slope = [&](double dnu, double dh) {
    const auto at = [&](double by) {
      Sensor moved = sensor;
      moved.poisson += by * dnu;
      moved.thickness += by * dh;
      const LayerModel beside = layer_model(moved);
      Scene own = scene;
      own.sensor = beside.sensor;
      return outputs(PatchSolver(beside, exact_sweeps({})).solve_on(trace.patch, own));
    };
    return central_difference(at, 1, dnu + dh);
  };
  EXPECT_LE(difference(derivative(d, "sensor.poisson"), slope(2e-3, 0), outputs(solution), 1), 1e-3);
  EXPECT_LE(difference(derivative(d, "sensor.thickness"), slope(0, 2e-3), outputs(solution), 1), 1e-3);
  LayerModel bare = model;
  bare.sides = FreeSides();
  LayerDerivatives without(bare);
  PatchSolver(bare, exact_sweeps({})).solve_on(trace.patch, scene, &trace);
  const SceneDerivatives none = patch_derivatives(bare, without, scene, trace, {});
  EXPECT_GT(difference(derivative(none, "sensor.poisson"), slope(2e-3, 0), outputs(solution), 1), 1e-2)
      << "the sides do not count in this scene";
}

}  // namespace
}  // namespace tactel::fem
