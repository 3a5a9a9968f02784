// SPDX-License-Identifier: Apache-2.0
#include "host/figures/contact_view.h"

#include <algorithm>
#include <set>

#include "fem/gap/stress_field.h"
#include "host/figures/contact_figure.h"
#include "host/figures/grid_field.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;
using fem::ContactSolution;
using fem::ContactStep;
using Range = std::pair<double, double>;

constexpr int field_columns = 81, field_rows = 13;

// ---- which steps, and which part of the sensor

/// Bytes of a step on the page, about: the fields, then a few numbers a node and a tactel.
std::size_t bytes_of_step(const ContactSolution& solution) {
  return 5 * 4 * field_columns * field_rows / 3 + 45 * static_cast<std::size_t>(solution.surface_x.size()) +
         18 * static_cast<std::size_t>(solution.tactel_x.size());
}

/// The touched part of the surface over all steps, with the rubber around it.
Range window_of(const fem::Scene& scene, const ContactSolution& solution) {
  const double thickness = scene.sensor.thickness, half = 0.5 * scene.sensor.length;
  double left = std::clamp(scene.indenter.position, -half, half), right = left;
  for (const ContactStep& step : solution.steps) {
    const fem::Interval part = touched_part(solution, step);
    left = std::min(left, part.left), right = std::max(right, part.right);
  }
  const double room = std::max(1.2 * thickness, 0.5 * (3.2 * thickness - (right - left)));
  return {std::max(-half, left - room), std::min(half, right + room)};
}

// ---- the field

/// The mesh on which the field is computed: the scene's own, or for a patch one that resolves its tractions.
fem::Sensor field_sensor(const fem::Scene& scene, bool patch) {
  fem::Sensor sensor = scene.sensor;
  if (!patch) return sensor;
  const int intervals = static_cast<int>(std::ceil(24 * sensor.length / sensor.thickness));
  sensor.columns = std::clamp(intervals, 40, 800) + 1;
  sensor.rows = 17;
  sensor.grading = 4;
  sensor.element = fem::Element::bbar;
  return sensor;
}

/// [2 columns] N/mm: force on the rubber at each surface node of the field's mesh.
Eigen::VectorXd surface_load(const ContactSolution& solution, const ContactStep& step, const Eigen::VectorXd& node_x) {
  const bool patch = solution.surface_width.size() > 0;
  const auto at_nodes = [&](const Eigen::VectorXd& force) -> Eigen::VectorXd {
    return patch ? nodal_loads(force, solution.surface_x, solution.surface_width, node_x) : force;
  };
  Eigen::VectorXd load(2 * node_x.size());
  load(Eigen::seq(0, Eigen::last, 2)) = at_nodes(step.tangential_force);
  load(Eigen::seq(1, Eigen::last, 2)) = -at_nodes(step.normal_force);
  return load;
}

std::vector<fem::StressField> fields_of(const fem::Sensor& sensor, const ContactSolution& solution,
                                        const std::vector<std::size_t>& steps) {
  const Eigen::VectorXd node_x = fem::surface_positions(sensor);
  Eigen::MatrixXd loads(2 * node_x.size(), static_cast<Eigen::Index>(steps.size()));
  for (std::size_t k = 0; k < steps.size(); ++k)
    loads.col(static_cast<Eigen::Index>(k)) = surface_load(solution, solution.steps[steps[k]], node_x);
  return fem::stress_fields(sensor, loads);
}

/// One quantity at the points of the picture: [steps][rows * columns].
struct Quantity {
  std::string name, unit;
  std::vector<std::vector<double>> values{};
  double low = 0, high = 0;
  bool clipped = false;  ///< some values lie beyond low and high

  /// Limits that leave out one value in `rare`: a corner of the indenter does not take all colours.
  void limit(std::size_t rare) {
    std::vector<double> all;
    for (const auto& step : values) all.insert(all.end(), step.begin(), step.end());
    std::ranges::sort(all);
    const std::size_t out = rare ? all.size() / rare : 0;
    low = all[out], high = all[all.size() - 1 - out];
    clipped = all.front() < low - 0.05 * (high - low) || all.back() > high + 0.05 * (high - low);
  }
  std::string bytes(std::size_t step) const {
    std::vector<std::uint8_t> out;
    const double scale = high > low ? 255 / (high - low) : 0;
    for (const double value : values[step])
      out.push_back(static_cast<std::uint8_t>(std::lround(std::clamp((value - low) * scale, 0.0, 255.0))));
    return base64(out);
  }
};

std::vector<Quantity> quantities(const std::vector<fem::StressField>& fields, Range window) {
  std::vector<Quantity> all = {{"u_x", "mm"}, {"u_y", "mm"}, {"σ_y", "MPa"}, {"τ_{xy}", "MPa"}, {"von Mises", "MPa"}};
  for (const fem::StressField& field : fields) {
    const auto add = [&](Quantity& quantity, const Eigen::VectorXd& values) {
      quantity.values.push_back(resampled(corner_grid(field.mesh, values), window, field_rows, field_columns));
    };
    for (Eigen::Index k : {0, 1}) add(all[static_cast<std::size_t>(k)], field.displacement.row(k));
    for (Eigen::Index k : {1, 2}) add(all[static_cast<std::size_t>(k + 1)], field.stress.row(k));
    add(all[4], field.von_mises);
  }
  for (std::size_t k = 0; k < all.size(); ++k) all[k].limit(k < 2 ? 0 : 400);
  all[4].low = 0;
  return all;
}

/// Displacement of the surface at places [n] mm.
Eigen::VectorXd surface_displacement(const fem::StressField& field, Eigen::Index direction, const Eigen::VectorXd& x) {
  const auto& surface = field.mesh.surface;
  Eigen::VectorXd out(x.size());
  std::size_t right = 1;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    while (right + 1 < surface.size() && field.mesh.node(0, surface[right]) < x[k]) ++right;
    const int a = surface[right - 1], b = surface[right];
    const double part = (x[k] - field.mesh.node(0, a)) / (field.mesh.node(0, b) - field.mesh.node(0, a));
    out[k] = (1 - part) * field.displacement(direction, a) + part * field.displacement(direction, b);
  }
  return out;
}

// ---- what is drawn of it

/// A factor on displacements that makes small ones visible: 1, 2, 5, 10, ...
double exaggeration_of(const std::vector<Quantity>& all, double thickness) {
  constexpr double visible = 0.06;  // of the thickness
  double most = 0;
  for (std::size_t k : {0u, 1u}) most = std::max({most, -all[k].low, all[k].high});
  if (!(most > 0)) return 1;
  double factor = 1;
  for (int k = 0; factor * most < visible * thickness && k < 12; ++k) factor *= k % 3 == 1 ? 2.5 : 2;
  return factor;
}

/// The outline of the indenter from its position on, with its edges.
Json outline(const fem::Indenter& indenter, Range window) {
  constexpr int points = 200;
  const double reach = window.second - window.first;
  std::vector<double> x;
  for (int i = 0; i <= points; ++i) x.push_back(window.first - reach + 3 * reach * i / points);
  const fem::Interval lowest = fem::lowest_part(indenter);
  for (double edge : {lowest.left, lowest.right})
    if (std::isfinite(edge)) x.push_back(edge);
  std::ranges::sort(x);
  std::vector<double> kept, height;
  for (const double at : x) {
    const double y = fem::profile_height(indenter, at);
    if (!std::isfinite(y)) continue;
    kept.push_back(at);
    height.push_back(y);
  }
  return {{"x", rounded(kept)}, {"y", rounded(height)}};
}

Json path_json(const ContactSolution& solution) {
  std::vector<double> number, P, Q, S, stick;
  for (const ContactStep& step : solution.steps) {
    number.push_back(static_cast<double>(number.size() + 1));
    P.push_back(step.P), Q.push_back(step.Q), S.push_back(step.slip_index.value_or(NAN)),
        stick.push_back(sticking_share(step));
  }
  return {
      {"number", rounded(number)}, {"P", rounded(P)}, {"Q", rounded(Q)}, {"S", rounded(S)}, {"stick", rounded(stick)}};
}

/// Builds the view step by step.
class Builder {
 public:
  Builder(const fem::Scene& scene, const ContactSolution& solution, std::size_t shown)
      : scene_(scene),
        solution_(solution),
        window_(window_of(scene, solution)),
        steps_(shown_steps(solution.steps.size(), shown, bytes_of_step(solution))),
        shown_(shown),
        sensor_(field_sensor(scene, patch())),
        fields_(fields_of(sensor_, solution, steps_)),
        quantities_(quantities(fields_, window_)) {
    for (Eigen::Index i = 0; i < solution.surface_x.size(); ++i)
      if (solution.surface_x[i] >= window_.first && solution.surface_x[i] <= window_.second) nodes_.push_back(i);
  }

  ContactView view() const { return {data(), caption()}; }

 private:
  bool patch() const { return solution_.surface_width.size() > 0; }
  bool bonded() const { return std::isinf(scene_.friction); }
  Eigen::VectorXd in_window(const Eigen::VectorXd& values) const { return values(nodes_); }

  Eigen::VectorXd traction(const Eigen::VectorXd& force) const { return traction_of(force, solution_); }

  Json step_json(std::size_t k) const {
    const ContactStep& step = solution_.steps[steps_[k]];
    std::string status;
    for (const Eigen::Index i : nodes_) status += "otl"[static_cast<int>(step.status[static_cast<std::size_t>(i)])];
    const Eigen::VectorXd x = in_window(solution_.surface_x);
    Json fields = Json::array();
    for (const Quantity& quantity : quantities_) fields.push_back(quantity.bytes(k));
    return {{"number", steps_[k] + 1},
            {"indentation", rounded(step.indentation)},
            {"tangential", rounded(step.tangential)},
            {"P", rounded(step.P, 6)},
            {"Q", rounded(step.Q, 6)},
            {"S", rounded(step.slip_index.value_or(NAN), 6)},
            {"status", status},
            {"p", rounded(in_window(traction(step.normal_force)))},
            {"q", rounded(in_window(traction(step.tangential_force)))},
            {"ux", rounded(surface_displacement(fields_[k], 0, x), 4)},
            {"uy", rounded(surface_displacement(fields_[k], 1, x), 4)},
            {"sigma", rounded(step.sigma_y)},
            {"tau", rounded(step.tau_xy)},
            {"fields", std::move(fields)}};
  }

  Json field_json() const {
    Json all = Json::array();
    for (const Quantity& q : quantities_)
      all.push_back({{"name", q.name},
                     {"unit", q.unit},
                     {"low", rounded(q.low)},
                     {"high", rounded(q.high)},
                     {"clipped", q.clipped}});
    return {{"rows", field_rows},
            {"columns", field_columns},
            {"x", rounded(std::array{window_.first, window_.second}, 9)},
            {"quantities", std::move(all)}};
  }

  /// Ranges over all steps that are shown, so that the axes stay where they are.
  Range traction_range() const {
    double low = 0, high = 0;
    for (const std::size_t k : steps_) {
      const Eigen::VectorXd p = traction(solution_.steps[k].normal_force),
                            q = traction(solution_.steps[k].tangential_force);
      high = std::max({high, p.maxCoeff(), q.maxCoeff()}), low = std::min(low, q.minCoeff());
      if (!bonded())
        low = std::min(low, -scene_.friction * p.maxCoeff()), high = std::max(high, scene_.friction * p.maxCoeff());
    }
    return {low * 1.06, high > 0 ? high * 1.06 : 1};
  }
  Range tactel_range() const {
    double low = 0, high = 0;
    for (const std::size_t k : steps_)
      for (const Eigen::VectorXd* values : {&solution_.steps[k].sigma_y, &solution_.steps[k].tau_xy})
        low = std::min(low, values->minCoeff()), high = std::max(high, values->maxCoeff());
    const double room = 0.06 * (high - low);
    return high > low ? Range(low - room, high + room) : Range(-1, 1);
  }
  std::array<double, 2> tactel_most() const {
    std::array<double, 2> most{};
    for (const std::size_t k : steps_) {
      most[0] = std::max(most[0], solution_.steps[k].sigma_y.cwiseAbs().maxCoeff());
      most[1] = std::max(most[1], solution_.steps[k].tau_xy.cwiseAbs().maxCoeff());
    }
    return most;
  }
  Range path_range() const {
    double low = 0, high = 1;
    for (const ContactStep& step : solution_.steps) {
      low = std::min(low, step.slip_index.value_or(0)), high = std::max(high, step.slip_index.value_or(0));
    }
    return {low < -1e-3 ? low - 0.06 : 0, high + 0.06};
  }

  Json data() const {
    Json steps = Json::array();
    for (std::size_t k = 0; k < steps_.size(); ++k) steps.push_back(step_json(k));
    const auto pair = [](Range r) { return rounded(std::array{r.first, r.second}, 6); };
    return {{"window", pair(window_)},
            {"thickness", scene_.sensor.thickness},
            {"position", scene_.indenter.position},
            {"exaggeration", exaggeration()},
            {"mu", bonded() ? Json() : Json(scene_.friction)},
            {"indenter", outline(scene_.indenter, window_)},
            {"surface_x", rounded(in_window(solution_.surface_x), 7)},
            {"surface_width", patch() ? rounded(in_window(solution_.surface_width), 7) : Json()},
            {"tactel_x", rounded(solution_.tactel_x, 7)},
            {"tactel_width", scene_.sensor.tactel_width},
            {"most_traction", pair(traction_range())},
            {"tactel_range", pair(tactel_range())},
            {"tactel_most", rounded(tactel_most())},
            {"path_range", pair(path_range())},
            {"path", path_json(solution_)},
            {"field", field_json()},
            {"shown", std::ranges::find(steps_, shown_) - steps_.begin()},
            {"steps", std::move(steps)}};
  }
  double exaggeration() const { return exaggeration_of(quantities_, scene_.sensor.thickness); }

  std::string caption() const {
    const std::string mesh = fmt::format("{} x {} {}", sensor_.columns, sensor_.rows, fem::name(sensor_.element));
    const double factor = exaggeration();
    return fmt::format(
        "A {} pressed on {} x {} mm of rubber ({}E = {} MPa, ν = {}, µ = {}). Arrows: the forces of the indenter on "
        "the "
        "rubber. Pressure is positive in compression; shear, Q and S are positive towards +x; σ_y < 0 is compression. "
        "The colours of the rubber are {} on {} x {} points with 8 bits, one scale for all steps{}. {}{}The tiles "
        "under "
        "the base are the tactels.",
        fem::shape_name(scene_.indenter.shape), scene_.sensor.length, scene_.sensor.thickness,
        scene_.sensor.layers.empty() ? "" : fmt::format("{} layers, at the surface ", scene_.sensor.layers.size()),
        scene_.sensor.young, scene_.sensor.poisson, bonded() ? "infinite" : fmt::format("{}", scene_.friction),
        patch() ? fmt::format("the stress of a mesh of {} under the patch's tractions", mesh)
                : fmt::format("the stress on the contact's own mesh of {}", mesh),
        field_columns, field_rows, clipped() ? "; the rarest 0.25 % at either end are cut off" : "",
        factor == 1 ? "" : fmt::format("Displacements and the indenter's height are drawn {} times as large. ", factor),
        steps_left_out(steps_.size(), solution_.steps.size()));
  }
  bool clipped() const { return std::ranges::any_of(quantities_, &Quantity::clipped); }

  const fem::Scene& scene_;
  const ContactSolution& solution_;
  Range window_;
  std::vector<std::size_t> steps_;
  std::size_t shown_;
  fem::Sensor sensor_;
  std::vector<fem::StressField> fields_;
  std::vector<Quantity> quantities_;
  std::vector<Eigen::Index> nodes_;  ///< in the window
};

}  // namespace

ContactView contact_view(const fem::Scene& scene, const ContactSolution& solution, std::size_t shown) {
  return Builder(scene, solution, shown).view();
}

Eigen::VectorXd nodal_loads(const Eigen::VectorXd& force, const Eigen::VectorXd& place, const Eigen::VectorXd& width,
                            const Eigen::VectorXd& node_x) {
  Eigen::VectorXd load = Eigen::VectorXd::Zero(node_x.size());
  for (Eigen::Index e = 0; e < force.size(); ++e) {
    const double left = place[e] - 0.5 * width[e], right = place[e] + 0.5 * width[e], traction = force[e] / width[e];
    for (Eigen::Index i = 0; i + 1 < node_x.size(); ++i) {
      const double from = std::max(left, node_x[i]), to = std::min(right, node_x[i + 1]);
      if (!(from < to)) continue;
      const double part = (0.5 * (from + to) - node_x[i]) / (node_x[i + 1] - node_x[i]);
      load[i] += traction * (to - from) * (1 - part);
      load[i + 1] += traction * (to - from) * part;
    }
  }
  return load;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned word = (bytes[i] << 16u) | ((left > 1 ? bytes[i + 1] : 0u) << 8u) | (left > 2 ? bytes[i + 2] : 0u);
    for (unsigned k = 0; k < 4; ++k) out += k <= left ? letters[(word >> (18 - 6 * k)) & 63u] : '=';
  }
  return out;
}

std::vector<std::size_t> shown_steps(std::size_t count, std::size_t shown, std::size_t bytes_each) {
  constexpr std::size_t budget = 330'000, most_steps = 24;  // bytes of all steps
  const std::size_t most = std::clamp<std::size_t>(budget / bytes_each, 2, most_steps);
  std::set<std::size_t> steps = {shown, count - 1};
  const std::size_t even = count <= most ? count : most - 2;  // evenly along the path, from the first on
  for (std::size_t k = 0; k < even; ++k) steps.insert(k * count / even);
  return {steps.begin(), steps.end()};
}

std::string steps_left_out(std::size_t shown, std::size_t count) {
  return shown == count ? "" : fmt::format("{} of {} load steps are shown. ", shown, count);
}

}  // namespace tactel::host
