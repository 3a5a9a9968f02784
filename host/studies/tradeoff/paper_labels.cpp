// SPDX-License-Identifier: Apache-2.0
#include "host/studies/tradeoff/paper_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/contact/contact_fallback.h"
#include "host/contact/rung_error.h"
#include "host/contact/solve_on_rung.h"
#include "host/scenes/paper_sets.h"

namespace tactel::host {
namespace {

using Answers = std::vector<fem::ContactSolution>;

/// One label of the mesh beside the reference; stresses relative to the contact's largest.
struct Label {
  double S = 0, patch = 0, inner_sigma = 0, inner_tau = 0, end_sigma = 0, end_tau = 0;
};

struct JudgedContact {
  std::string shapes;     ///< class of the recall set
  std::size_t nodes = 0;  ///< of the mesh that touch at full indentation
  std::vector<Label> labels;
};

/// The scene for models without a mesh: the steps that the drag on the mesh took, and stresses of the default kind
/// where a mesh answers after all.
fem::Scene with_steps_of(const fem::Scene& scene, const fem::ContactSolution& answer) {
  fem::Scene same = scene;
  const auto pressing = static_cast<std::size_t>(fem::load_path(scene.load).indentation_steps);
  same.load.tangential_steps = static_cast<int>(answer.steps.size() - pressing);
  const fem::Sensor usual;
  same.sensor.element = usual.element;
  same.sensor.stress = usual.stress;
  same.sensor.grading = usual.grading;
  return same;
}

double largest_stress(const fem::ContactSolution& answer, Eigen::VectorXd fem::ContactStep::*stress) {
  double value = 0;
  for (const fem::ContactStep& step : answer.steps)
    value = std::max(value, (step.*stress).segment(1, (step.*stress).size() - 2).cwiseAbs().maxCoeff());
  return value;
}

std::pair<double, double> inner_and_end(const Eigen::VectorXd& stress, const Eigen::VectorXd& judge, double scale) {
  const Eigen::VectorXd off = (stress - judge).cwiseAbs() / scale;
  const Eigen::Index last = off.size() - 1;
  return {off.segment(1, last - 1).maxCoeff(), std::max(off[0], off[last])};
}

JudgedContact judged(const fem::ContactSolution& mesh, const fem::ContactSolution& patch,
                     const fem::ContactSolution& judge, int pressing_steps) {
  JudgedContact contact;
  const double sigma = largest_stress(judge, &fem::ContactStep::sigma_y),
               tau = largest_stress(judge, &fem::ContactStep::tau_xy);
  const auto first = static_cast<std::size_t>(pressing_steps) - 1;
  contact.nodes = static_cast<std::size_t>((mesh.steps[first].normal_force.array() > 0).count());
  for (std::size_t k = first; k < mesh.steps.size(); ++k) {
    const fem::ContactStep &a = mesh.steps[k], &b = judge.steps[k], &p = patch.steps[k];
    if (!a.slip_index || !b.slip_index || !p.slip_index) continue;
    Label label{.S = *a.slip_index - *b.slip_index, .patch = *p.slip_index - *b.slip_index};
    std::tie(label.inner_sigma, label.end_sigma) = inner_and_end(a.sigma_y, b.sigma_y, sigma);
    std::tie(label.inner_tau, label.end_tau) = inner_and_end(a.tau_xy, b.tau_xy, tau);
    contact.labels.push_back(label);
  }
  return contact;
}

LabelGroup group(std::string what, const std::vector<JudgedContact>& contacts,
                 const std::function<bool(const JudgedContact&)>& belongs) {
  LabelGroup group{.what = std::move(what)};
  std::vector<Label> labels;
  for (const JudgedContact& contact : contacts) {
    if (!belongs(contact)) continue;
    ++group.contacts;
    labels.insert(labels.end(), contact.labels.begin(), contact.labels.end());
  }
  group.labels = labels.size();
  const auto of = [&](double Label::*member) {
    std::vector<double> values;
    for (const Label& label : labels) values.push_back(std::abs(label.*member));
    return LabelError{covering_value(values, 0.5), covering_value(values, 0.95), covering_value(values, 1)};
  };
  for (const Label& label : labels) group.bias += label.S / static_cast<double>(labels.size());
  group.mesh = of(&Label::S);
  group.patch = of(&Label::patch);
  group.inner_sigma = of(&Label::inner_sigma).most95;
  group.inner_tau = of(&Label::inner_tau).most95;
  group.end_sigma = of(&Label::end_sigma).most95;
  group.end_tau = of(&Label::end_tau).most95;
  return group;
}

/// Contacts of a family, those left out that the judge did not solve.
std::vector<JudgedContact> judged_family(Executor& executor, const SceneFamily& family, const Rung& judge_rung,
                                         std::size_t& unjudged, const std::function<void()>& step) {
  step();
  const Answers mesh = solve_on_meshes(executor, family.scenes, Precision::fp64);
  std::vector<fem::Scene> scenes;
  for (std::size_t i = 0; i < mesh.size(); ++i) scenes.push_back(with_steps_of(family.scenes[i], mesh[i]));
  step();
  const Answers patch = solve_on_rung(executor, scenes, usual_patch());
  step();
  const Answers judge = solve_on_rung(executor, scenes, judge_rung);
  std::vector<JudgedContact> contacts;
  for (std::size_t i = 0; i < mesh.size(); ++i) {
    if (!every_step_converged(judge[i])) {
      ++unjudged;
      continue;
    }
    contacts.push_back(judged(mesh[i], patch[i], judge[i], fem::load_path(scenes[i].load).indentation_steps));
    contacts.back().shapes = family.kind_names[family.kind[i]];
  }
  return contacts;
}

void add_groups(const std::string& set, const std::vector<JudgedContact>& contacts, std::vector<LabelGroup>& groups) {
  groups.push_back(group(set, contacts, [](const JudgedContact&) { return true; }));
  struct Range {
    std::size_t least, most;
    const char* text;
  };
  for (const Range& range : {Range{1, 3, "1 to 3"}, Range{4, 10, "4 to 10"}, Range{11, SIZE_MAX, "11 or more"}})
    groups.push_back(group(fmt::format("  {} nodes touch", range.text), contacts,
                           [&](const JudgedContact& c) { return c.nodes >= range.least && c.nodes <= range.most; }));
  std::erase_if(groups, [](const LabelGroup& g) { return g.contacts == 0; });
}

std::vector<double> errors(const std::vector<JudgedContact>& contacts) {
  std::vector<double> result;
  for (const JudgedContact& contact : contacts)
    for (const Label& label : contact.labels) result.push_back(std::abs(label.S));
  return result;
}

Series share_over_error(std::vector<double> errors, const char* label, Ink ink) {
  std::ranges::sort(errors);
  Series series{.label = label, .ink = ink};
  for (std::size_t k = 0; k < errors.size(); ++k) {
    series.x.push_back(std::max(errors[k], 1e-4));
    series.y.push_back(100 * static_cast<double>(k + 1) / static_cast<double>(errors.size()));
  }
  return series;
}

}  // namespace

PaperLabels measure_paper_labels(Executor& executor, const std::function<bool(std::size_t, std::size_t)>& progress,
                                 const Rung& judge) {
  std::size_t done = 0;
  const auto step = [&] {
    if (progress && !progress(done++, 6)) throw Stopped("stopped; no report is written");
  };
  const fem::Scene base = paper_set_scene();
  const SceneFamily recall = paper_recall_family(base);
  PaperLabels result;
  const auto learning = judged_family(executor, paper_learning_family(base, 10, 10), judge, result.unjudged, step);
  const auto recalling = judged_family(executor, recall, judge, result.unjudged, step);
  add_groups("learning set", learning, result.groups);
  add_groups("recall set", recalling, result.groups);
  for (const std::string& shapes : recall.kind_names)
    result.groups.push_back(
        group("  " + shapes, recalling, [&](const JudgedContact& c) { return c.shapes == shapes; }));
  result.learning = errors(learning);
  result.recalling = errors(recalling);
  return result;
}

nlohmann::ordered_json to_json(const PaperLabels& labels) {
  nlohmann::ordered_json groups = nlohmann::ordered_json::array();
  const auto error = [](const LabelError& e) {
    return nlohmann::ordered_json{{"median", e.median}, {"most95", e.most95}, {"largest", e.largest}};
  };
  for (const LabelGroup& g : labels.groups)
    groups.push_back({{"what", g.what},
                      {"contacts", g.contacts},
                      {"labels", g.labels},
                      {"bias_S", g.bias},
                      {"mesh_S", error(g.mesh)},
                      {"patch_S", error(g.patch)},
                      {"inner_tactels", {{"sigma_most95", g.inner_sigma}, {"tau_most95", g.inner_tau}}},
                      {"end_tactels", {{"sigma_most95", g.end_sigma}, {"tau_most95", g.end_tau}}}});
  return {{"tactel", TACTEL_VERSION},
          {"unjudged", labels.unjudged},
          {"groups", std::move(groups)},
          {"learning_errors_S", labels.learning},
          {"recall_errors_S", labels.recalling}};
}

std::string labels_table(const PaperLabels& labels) {
  std::string out = fmt::format(
      "{:<26} {:>8} {:>6} | {:^31} | {:^23} | {:^13} | {:^13}\n{:<42} | {:>7} {:>7} {:>7} {:>7}"
      " | {:>7} {:>7} {:>7} | {:>6} {:>6} | {:>6} {:>6}\n",
      "labels of the paper's mesh", "contacts", "labels", "error in S", usual_patch().name, "inner tactels",
      "end tactels", "", "median", "95 %", "largest", "mean", "median", "95 %", "largest", "sigma", "tau", "sigma",
      "tau");
  for (const LabelGroup& g : labels.groups)
    out += fmt::format(
        "{:<26} {:>8} {:>6} | {:7.2g} {:7.2g} {:7.2g} {:7.2g} | {:7.2g} {:7.2g} {:7.2g} | {:6.2g} {:6.2g}"
        " | {:6.2g} {:6.2g}\n",
        g.what, g.contacts, g.labels, g.mesh.median, g.mesh.most95, g.mesh.largest, g.bias, g.patch.median,
        g.patch.most95, g.patch.largest, g.inner_sigma, g.inner_tau, g.end_sigma, g.end_tau);
  if (labels.unjudged) out += fmt::format("{} contacts left out: the reference did not solve them\n", labels.unjudged);
  return out;
}

Figure labels_figure(const PaperLabels& labels) {
  Panel panel{.x_label = "error in S of a label of the paper's mesh",
              .y_label = "share of the labels, %",
              .series = {share_over_error(labels.learning, "learning set", Ink::blue),
                         share_over_error(labels.recalling, "recall set", Ink::orange)},
              .log_x = true};
  return {.title = "Labels of the paper's mesh", .panels = {panel}, .width = 820, .panel_height = 320};
}

}  // namespace tactel::host
