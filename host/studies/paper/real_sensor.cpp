// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/real_sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "host/contact/lines/solve_on_rung.h"
#include "host/sets/transducer_chain.h"
#include "nn/philox.h"

namespace tactel::host {
namespace {

double tangent(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }

/// S and labels of every contact; frames of zeros.
nn::FrameSet labelled(const std::vector<RealContact>& contacts, const std::vector<fem::ContactSolution>& solutions) {
  const auto rows = static_cast<Eigen::Index>(contacts.size());
  nn::FrameSet set{nn::RowMatrix<float>::Zero(rows, 2 * solutions[0].tactel_x.size()), nn::Vector<float>(rows), {}, {}};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    set.slip_index(static_cast<Eigen::Index>(i)) = static_cast<float>(contacts[i].slip_index());
    set.shape_class.push_back(contacts[i].indenter);
    const auto& status = solutions[i].steps.back().status;
    set.contact_nodes.push_back(
        static_cast<std::int32_t>(status.size() - std::ranges::count(status, fem::GapStatus::open)));
  }
  return set;
}

}  // namespace

const std::vector<RealIndenter>& real_indenters() {
  static const std::vector<RealIndenter> all{
      {"flat, 4 mm", fem::Flat{2.0}},           {"flat, 6 mm", fem::Flat{3.0}},
      {"flat, 10 mm", fem::Flat{5.0}},          {"cylinder, 10 mm", fem::Cylinder{10.0}},
      {"cylinder, 30 mm", fem::Cylinder{30.0}}, {"edge, 60°", fem::Wedge{60.0}},
      {"edge, 120°", fem::Wedge{120.0}},
  };
  return all;
}

std::uint32_t Record::samples() const { return static_cast<std::uint32_t>(std::lround(seconds * rate)); }

double HandPress::load(double t) const {
  const double rising = (t - start) / rise, falling = (start + rise + hold + release - t) / release;
  return std::clamp(std::min(rising, falling), 0.0, 1.0);
}

HandPress hand_press(std::uint64_t seed, std::uint32_t number) {
  const auto words = nn::random_words(seed, nn::RandomStream::contact, number);
  const auto between = [](std::uint32_t word, double low, double high) { return low + (high - low) * word * 0x1p-32; };
  return {between(words[0], 2, 5), between(words[1], 0.5, 1.5), between(words[2], 1, 2), between(words[3], 0.3, 0.7)};
}

std::vector<float> pressed_record(const fem::ContactSolution& solution, const HandPress& press, const Record& record) {
  const auto steps = static_cast<Eigen::Index>(solution.steps.size());
  const Eigen::Index tactels = solution.tactel_x.size();
  Eigen::MatrixXd knots = Eigen::MatrixXd::Zero(2 * tactels, steps + 1);  // [channels, load steps from no load on] MPa
  for (Eigen::Index k = 0; k < steps; ++k) knots.col(k + 1) << solution.steps[k].sigma_y, solution.steps[k].tau_xy;
  std::vector<float> stress(record.samples() * knots.rows());
  for (std::uint32_t sample = 0; sample < record.samples(); ++sample) {
    const double at = press.load(sample / record.rate) * static_cast<double>(steps);
    const auto from = std::min(static_cast<Eigen::Index>(at), steps - 1);
    const double share = at - static_cast<double>(from);
    Eigen::Map<Eigen::VectorXf>(&stress[sample * knots.rows()], knots.rows()) =
        ((1 - share) * knots.col(from) + share * knots.col(from + 1)).cast<float>();
  }
  return stress;
}

std::size_t highest_normal_sample(std::span<const float> record, std::size_t channels) {
  std::size_t highest = 0;
  float most = record[0];
  for (std::size_t sample = 0; sample < record.size() / channels; ++sample) {
    const float compression = std::ranges::min(record.subspan(sample * channels, channels / 2));
    if (compression < most) highest = sample, most = compression;
  }
  return highest;
}

double RealContact::friction() const { return tangent(limit_angle); }
double RealContact::slip_index() const { return tangent(angle) / tangent(limit_angle); }

std::vector<RealContact> real_contacts() {
  std::vector<RealContact> all;
  const auto indenters = static_cast<std::uint16_t>(real_indenters().size());
  for (std::uint16_t indenter = 0; indenter < indenters; ++indenter)
    for (double position : {-2.5, 0.0, 2.5})
      for (double limit : {25.0, 38.0})
        for (double angle : {0.0, 15.0, 30.0})
          if (angle < limit) all.push_back({indenter, position, limit, angle});
  return all;
}

RealSensorChoice real_sensor_choice() {
  RealSensorChoice choice;
  choice.sensor.columns = 321;  // 0.06 mm apart: three or more stand under the sharpest edge
  choice.sensor.tactels = 8;
  choice.sensor.tactel_span = 17.5;  // mm: a pitch of 2.5, the distance between the paper's positions
  choice.sensor.tactel_width = 2.0;  // mm: two shavings of film of 1 mm side by side (section III)
  choice.chain = {.gain_spread = 0.2,
                  .time_constant = 1,
                  .step_time = 1 / choice.record.rate,
                  .noise = 0.00075,  // MPa: 0.5 % of the range
                  .range = 0.15,     // MPa: twice the largest stress, and room for the gains
                  .bits = 12,
                  .instances = 1};
  return choice;
}

fem::Scene real_scene(const RealSensorChoice& choice, const RealContact& contact) {
  fem::Scene scene;
  scene.sensor = choice.sensor;
  scene.indenter = {real_indenters()[contact.indenter].shape, contact.position};
  scene.friction = contact.friction();
  scene.load.normal_force = {choice.normal_force};
  scene.load.indentation_steps = choice.increments;
  scene.load.angle = contact.angle;
  return scene;
}

std::vector<fem::ContactSolution> solve_real_contacts(Executor& executor, const RealSensorChoice& choice,
                                                      const std::vector<RealContact>& contacts) {
  std::vector<fem::Scene> scenes;
  scenes.reserve(contacts.size());
  for (const RealContact& contact : contacts) scenes.push_back(real_scene(choice, contact));
  auto solutions = solve_on_meshes(executor, scenes, Precision::fp64);
  for (const fem::ContactSolution& solution : solutions)
    if (!solution.steps.back().converged)
      throw std::runtime_error("the paper's real sensor: a load step did not meet its tolerance");
  return solutions;
}

nn::FrameSet ideal_frames(const std::vector<RealContact>& contacts,
                          const std::vector<fem::ContactSolution>& solutions) {
  nn::FrameSet set = labelled(contacts, solutions);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const fem::ContactStep& full = solutions[i].steps.back();
    set.frames.row(static_cast<Eigen::Index>(i)) << full.sigma_y.cast<float>().transpose(),
        full.tau_xy.cast<float>().transpose();
  }
  return set;
}

std::vector<float> read_records(Executor& executor, const RealSensorChoice& choice,
                                const std::vector<fem::ContactSolution>& solutions, std::uint64_t seed) {
  nn::Transducer sensor = choice.chain;
  sensor.seed = seed;
  std::vector<TransducerChain::Contact> contacts;
  std::vector<float> records;
  for (std::uint32_t i = 0; i < solutions.size(); ++i) {
    const auto stress = pressed_record(solutions[i], hand_press(seed, i), choice.record);
    records.insert(records.end(), stress.begin(), stress.end());
    contacts.push_back({.number = i, .steps = choice.record.samples()});
  }
  TransducerChain(executor, sensor, seed, 2 * choice.sensor.tactels).run(contacts, records);
  return records;
}

nn::FrameSet recorded_frames(const std::vector<RealContact>& contacts,
                             const std::vector<fem::ContactSolution>& solutions, std::span<const float> records) {
  nn::FrameSet set = labelled(contacts, solutions);
  const auto channels = static_cast<std::size_t>(set.frames.cols());
  const std::size_t length = records.size() / contacts.size();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::span<const float> record = records.subspan(i * length, length);
    const std::size_t sample = highest_normal_sample(record, channels);
    std::ranges::copy(record.subspan(sample * channels, channels), set.frames.row(static_cast<Eigen::Index>(i)).data());
  }
  return set;
}

}  // namespace tactel::host
