// SPDX-License-Identifier: Apache-2.0
#include "host/training/frame_floor.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "fem/value_error.h"
#include "host/scenes/ladder.h"
#include "host/scenes/sweep_file.h"
#include "host/sets/set_simulator.h"
#include "host/support/errors.h"
#include "host/training/answered_rows.h"

namespace tactel::host {
namespace {

constexpr double shift = 1.0 / 64;
constexpr double least_noise = 1e-4;  // over the contact's largest stress: below it the rounding of fp32 counts
constexpr std::uint64_t simulated_lines = 4096, fewest_contacts = 32;  // about a second of a processor

FrameFloor none(std::string reason) {
  FrameFloor floor;
  floor.reason = std::move(reason);
  return floor;
}

bool answered(const ChangedRows& rows, std::size_t row) {
  return rows.status[row] != over_tolerance && std::isfinite(rows.slip_index[row]);
}

/// The answered row of a contact and step.
std::optional<std::size_t> find(const ChangedRows& rows, std::uint64_t contact, std::uint32_t step) {
  auto row = static_cast<std::size_t>(std::ranges::lower_bound(rows.contact, contact) - rows.contact.begin());
  while (row < rows.contact.size() && rows.contact[row] == contact && rows.step[row] < step) ++row;
  const bool found = row < rows.contact.size() && rows.contact[row] == contact && rows.step[row] == step;
  return found && answered(rows, row) ? std::optional(row) : std::nullopt;
}

Eigen::Map<const Eigen::VectorXf> frame_of(const ChangedRows& rows, std::size_t row) {
  return {rows.frames.data() + row * static_cast<std::size_t>(rows.inputs), rows.inputs};
}

/// frames: [inputs, frames of a reading] MPa; j: [inputs x frames, numbers].
double linear_error(const Eigen::MatrixXd& frames, const Eigen::MatrixXd& j, const Eigen::VectorXd& g, double sigma,
                    double gain) {
  const double variance = sigma * sigma, gain2 = gain * gain;
  Eigen::MatrixXd precision = j.transpose() * j / variance;
  for (Eigen::Index t = 0; gain > 0 && t < frames.rows(); ++t) {  // of each transducer: Sherman, Morrison (1950)
    Eigen::VectorXd fj = Eigen::VectorXd::Zero(g.size());
    for (Eigen::Index m = 0; m < frames.cols(); ++m) fj += frames(t, m) * j.row(m * frames.rows() + t).transpose();
    precision -= gain2 / (variance * (variance + gain2 * frames.row(t).squaredNorm())) * fj * fj.transpose();
  }
  precision.diagonal().array() += 12;
  return std::sqrt(2 / std::numbers::pi * std::max(g.dot(precision.ldlt().solve(g)), 0.0));
}

double error_of(const ChangedRows& rows, std::span<const std::int64_t> places, double sigma, double gain) {
  const auto newest = static_cast<std::size_t>(places.front());
  const auto count = static_cast<Eigen::Index>(places.size());
  const auto numbers = static_cast<Eigen::Index>(rows.changes - 1);
  Eigen::MatrixXd frames = Eigen::MatrixXd::Zero(rows.inputs, count);
  for (Eigen::Index m = 0; m < count; ++m)
    if (places[m] >= 0) frames.col(m) = frame_of(rows, static_cast<std::size_t>(places[m])).cast<double>();
  Eigen::MatrixXd j = Eigen::MatrixXd::Zero(rows.inputs * count, numbers);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(numbers);
  for (Eigen::Index n = 0; n < numbers; ++n) {
    const auto moved = [&](std::int64_t place) {
      return find(rows, rows.contact[newest] + 1 + static_cast<std::uint64_t>(n),
                  rows.step[static_cast<std::size_t>(place)]);
    };
    if (!std::ranges::all_of(places, [&](std::int64_t place) { return place < 0 || moved(place); })) continue;
    for (Eigen::Index m = 0; m < count; ++m)
      if (places[m] >= 0)
        j.col(n).segment(m * rows.inputs, rows.inputs) =
            (frame_of(rows, *moved(places[m])).cast<double>() - frames.col(m)) / rows.shift;
    g(n) = (double{rows.slip_index[*moved(places.front())]} - double{rows.slip_index[newest]}) / rows.shift;
  }
  return linear_error(frames, j, g, sigma, gain);
}

/// Adds the rows first ... end - 1 of one contact, but for frames without normal stress. Returns the noise over the
/// contact's largest stress.
double add_readings(const ChangedRows& rows, std::size_t first, std::size_t end, int normals,
                    const nn::InputHistory& history, const nn::Transducer& noise, Readings& to) {
  nn::FrameHistory path(static_cast<std::size_t>(rows.inputs), history);
  std::vector<std::size_t> pushed;
  float largest = 0;
  for (std::size_t row = first; row < end; ++row)
    largest = std::max(largest, frame_of(rows, row).cwiseAbs().maxCoeff());
  if (largest == 0) return 0;
  const double share = std::max(noise.noise_from.value_or(noise.noise) / largest + noise.noise_of_largest, least_noise);
  for (std::size_t row = first; row < end; ++row) {
    if (!answered(rows, row)) continue;
    if (!pushed.empty() && rows.step[row] != rows.step[pushed.back()] + 1) path.clear();
    path.push(frame_of(rows, row).data());
    pushed.push_back(row);
    if (frame_of(rows, row).head(normals).isZero(0)) continue;
    to.rows.push_back(static_cast<std::int64_t>(row));
    for (int i = 1; i < history.frames; ++i) {
      const std::optional<std::size_t> age = path.age(i);
      to.rows.push_back(age ? static_cast<std::int64_t>(pushed[pushed.size() - 1 - *age]) : -1);
    }
    to.sigma.push_back(share * largest);
  }
  return share;
}

/// The mean and its standard error; the readings of a contact are one draw.
void take_mean(FrameFloor& floor, std::span<const double> errors, std::span<const std::size_t> ends) {
  for (const double error : errors) floor.mean += error / static_cast<double>(errors.size());
  double squares = 0;
  for (std::size_t c = 0, i = 0; c < ends.size(); ++c) {
    double off = 0;
    for (; i < ends[c]; ++i) off += errors[i] - floor.mean;
    squares += off * off;
  }
  const auto n = static_cast<double>(errors.size()), contacts = static_cast<double>(ends.size());
  floor.standard_error = std::sqrt(squares * contacts / std::max(contacts - 1, 1.0)) / n;
  floor.readings = errors.size(), floor.contacts = ends.size();
}

/// Rows of the first contacts of a sweep and of their changes, without noise.
ContactSet changed_rows(Executor& executor, AnySource source, std::uint64_t most) {
  SetOptions options;
  if (auto* lines = std::get_if<SceneSource>(&source); lines && lines->model() == fem::SurfaceModel::patch)
    model_on(usual_patch(), *lines, options);
  common(source).measure_with({}, common(source).seed());
  const std::uint64_t changes = std::visit([](const auto& of) { return of.changes(); }, source);
  const std::uint64_t of_lines = std::holds_alternative<SceneSource>(source) ? simulated_lines / changes : 0;
  const std::uint64_t contacts = std::min(most, std::max(fewest_contacts, of_lines));
  return SetSimulator(executor, source, options).simulate(0, contacts * changes);
}

FrameFloor floor_of(Executor& executor, const AnySource& source, const ContactSet& set,
                    const nn::InputHistory& history) {
  const AnySource changed = std::visit([](const auto& of) { return AnySource(of.changed(shift)); }, source);
  const ContactSet rows = changed_rows(executor, changed, set.contact.back() + 1);
  const nn::Transducer& noise = common(source).transducer();
  const ChangedRows view{.inputs = rows.inputs,
                         .changes = std::visit([](const auto& of) { return of.changes(); }, changed),
                         .shift = shift,
                         .frames = rows.frames,
                         .slip_index = rows.slip_index,
                         .contact = rows.contact,
                         .step = rows.step,
                         .status = rows.status};
  FrameFloor floor;
  floor.frames = history.frames;
  Readings readings;
  if (noise.instances == 0) readings.gain = noise.gain_spread_from.value_or(noise.gain_spread);
  std::vector<std::size_t> ends;  // of contacts, in readings
  for (std::size_t first = 0, end = 0; first < rows.rows(); first = end) {
    while (end < rows.rows() && rows.contact[end] == rows.contact[first]) ++end;
    if (rows.contact[first] % view.changes != 0) continue;
    const std::size_t before = readings.sigma.size();
    const double share = add_readings(view, first, end, rows.inputs / rows.axes, history, noise, readings);
    ends.push_back(readings.sigma.size());
    floor.noise += share * static_cast<double>(ends.back() - before);
  }
  if (readings.sigma.empty()) return none("no frame has normal stress");
  take_mean(floor, linear_errors(view, readings), ends);
  floor.noise /= static_cast<double>(floor.readings);
  return floor;
}

}  // namespace

std::vector<double> linear_errors(const ChangedRows& rows, const Readings& readings) {
  std::vector<double> errors(readings.sigma.size());
  const std::size_t frames = errors.empty() ? 0 : readings.rows.size() / errors.size();
  for (std::size_t k = 0; k < errors.size(); ++k)
    errors[k] = error_of(rows, std::span(readings.rows).subspan(k * frames, frames), readings.sigma[k], readings.gain);
  return errors;
}

std::string FrameFloor::text() const {
  if (!reason.empty()) return fmt::format("no floor of these frames: {}", reason);
  return fmt::format(
      "these frames allow a mean error of {:.3f} at best (floor: +- {:.3f} by {} {} of {} contacts, noise {:.2g} %)",
      mean, standard_error, readings, frames > 1 ? fmt::format("inputs of {} frames", frames) : "frames", contacts,
      100 * noise);
}

nlohmann::ordered_json to_json(const FrameFloor& floor) {
  if (!floor.reason.empty()) return {{"reason", floor.reason}};
  return {{"mean", floor.mean},         {"standard_error", floor.standard_error},
          {"contacts", floor.contacts}, {"readings", floor.readings},
          {"history", floor.frames},    {"noise", floor.noise}};
}

FrameFloor frame_floor(Executor& executor, const ContactSet& set, const std::string& file,
                       const nn::InputHistory& history) try {
  if (set.sweep.empty()) return none("the set holds no sweep file");
  const Sweep sweep = read_sweep_text(file, set.sweep, set.seed);
  if (!sweep.contacts().endless()) return none("its sweep lists its contacts, and draws no numbers");
  return floor_of(executor, sweep.source, set, history);
} catch (const ConfigError& error) {
  return none(error.what());
} catch (const ValueError& error) {
  return none(error.what());
}

}  // namespace tactel::host
