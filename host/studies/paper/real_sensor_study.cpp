// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/real_sensor_study.h"

#include <cmath>
#include <map>

#include "host/support/seconds.h"

namespace tactel::host {
namespace {

/// Both data, both scalings.
std::vector<RealSensorCase> all_cases() {
  std::vector<RealSensorCase> cases;
  for (RealData data : {RealData::stresses, RealData::records})
    for (nn::ScalingKind scaling : {nn::ScalingKind::set, nn::ScalingKind::frame}) cases.push_back({data, scaling});
  return cases;
}

TrainingPlan plan_of(const RealSensorCase& what, std::size_t seeds, const nn::OnlineOptions& training) {
  TrainingPlan plan;
  plan.topologies = {real_topology()};
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) plan.seeds.push_back(seed);
  plan.scaling = what.scaling;
  plan.options = training;
  return plan;
}

/// What the errors on all contacts say of some of them.
nn::ErrorReport report_of(const std::vector<double>& errors, const nn::FrameSet& set,
                          const std::vector<std::uint32_t>& rows) {
  std::vector<double> chosen;
  chosen.reserve(rows.size());
  for (std::uint32_t row : rows) chosen.push_back(errors[row]);
  return nn::report_errors(chosen, chosen_rows(set, rows));
}

/// Trains one case on one draw and adds its errors. False when it was stopped.
bool train_case(Executor& executor, const nn::FrameSet& set, const ContactDraw& draw, const TrainingPlan& plan,
                const TrainingRunOptions& run, RealSensorResult& result) {
  NetworkTraining<float> training(executor, chosen_rows(set, draw.learning), plan);
  if (!training.run(run)) return false;
  for (const std::vector<double>& errors : training.absolute_errors(set)) {
    result.learning.push_back(report_of(errors, set, draw.learning));
    result.recalling.push_back(report_of(errors, set, draw.recall));
    result.unseen.push_back(report_of(errors, set, draw.unseen));
  }
  for (const TrainedNetwork& network : training.networks()) result.learnt += network.status == nn::TrainStatus::learnt;
  return true;
}

/// All cases on one draw; counts the networks. False when it was stopped.
bool train_draw(Executor& executor, RealSensorStudy& study, std::uint64_t draw, const TrainingRunOptions& run,
                std::size_t& networks) {
  const RealSensorOptions& options = study.options;
  auto records = read_records(executor, study.choice, study.solutions, draw);
  const nn::FrameSet recorded = recorded_frames(study.contacts, study.solutions, records);
  if (draw == 1) study.records = std::move(records);
  const auto contacts = static_cast<std::uint32_t>(study.contacts.size());
  for (RealSensorResult& result : study.results) {
    const TrainingPlan plan = plan_of(result.what, options.seeds, options.training);
    const nn::FrameSet& set = result.what.data == RealData::stresses ? study.ideal : recorded;
    if (!train_case(executor, set, draw_contacts(draw, contacts), plan, run, result)) return false;
    networks += plan.seeds.size();
  }
  return true;
}

}  // namespace

const nn::Topology& real_topology() {
  static const nn::Topology topology({16, 16, 8, 1});
  return topology;
}

const char* name(RealData data) { return data == RealData::stresses ? "stresses" : "records"; }

ContactDraw draw_contacts(std::uint64_t draw, std::uint32_t contacts) {
  const auto order = nn::presentation_order(nn::PresentationOrder::permuted, draw, 0, contacts);
  const auto recall_end = order.begin() + paper_recalls, learning_end = recall_end + static_cast<long>(paper_examples);
  ContactDraw result{{recall_end, learning_end}, {order.begin(), recall_end}, {order.begin(), recall_end}};
  result.unseen.insert(result.unseen.end(), learning_end, order.end());
  return result;
}

nn::FrameSet chosen_rows(const nn::FrameSet& set, const std::vector<std::uint32_t>& rows) {
  nn::FrameSet chosen;
  chosen.frames = set.frames(rows, Eigen::all);
  chosen.slip_index = set.slip_index(rows);
  for (std::uint32_t row : rows) {
    chosen.shape_class.push_back(set.shape_class[row]);
    chosen.contact_nodes.push_back(set.contact_nodes[row]);
  }
  return chosen;
}

std::vector<double> errors_by_angle_alone(const std::vector<RealContact>& contacts) {
  std::map<double, std::pair<double, double>> range;  // of S, by angle
  for (const RealContact& contact : contacts) {
    const double s = contact.slip_index();
    auto& [low, high] = range.try_emplace(contact.angle, s, s).first->second;
    low = std::min(low, s), high = std::max(high, s);
  }
  std::vector<double> errors;
  for (const RealContact& contact : contacts) {
    const auto& [low, high] = range.at(contact.angle);
    errors.push_back(std::abs(contact.slip_index() - (low + high) / 2));
  }
  return errors;
}

std::optional<RealSensorStudy> study_real_sensor(Executor& executor, const RealSensorChoice& choice,
                                                 const RealSensorOptions& options) {
  const auto start = Clock::now();
  RealSensorStudy study;
  study.choice = choice;
  study.options = options;
  study.contacts = real_contacts();
  study.solutions = solve_real_contacts(executor, choice, study.contacts);
  study.ideal = ideal_frames(study.contacts, study.solutions);
  for (const RealSensorCase& what : all_cases()) study.results.push_back({what, {}, {}, {}});
  std::size_t networks = 0;
  const std::size_t all = all_cases().size() * options.draws * options.seeds;
  const TrainingRunOptions run{
      .progress = [&](std::size_t, std::size_t) { return !options.progress || options.progress(networks, all); },
      .checkpoint = {}};
  const auto contacts = static_cast<std::uint32_t>(study.contacts.size());
  const std::vector<double> by_angle = errors_by_angle_alone(study.contacts);
  for (std::uint64_t draw = 1; draw <= options.draws; ++draw) {
    if (!train_draw(executor, study, draw, run, networks)) return std::nullopt;
    const ContactDraw drawn = draw_contacts(draw, contacts);
    study.angle_alone.push_back(report_of(by_angle, study.ideal, drawn.recall));
  }
  for (RealSensorResult& result : study.results) result.learnt /= static_cast<double>(result.learning.size());
  study.seconds = seconds_since(start);
  return study;
}

}  // namespace tactel::host
