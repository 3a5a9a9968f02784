// SPDX-License-Identifier: Apache-2.0
#include "nn/frame_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "fem/numbers/value_error.h"

namespace tactel::nn {
namespace {

std::string at(const char* key, Eigen::Index row) { return std::string(key) + "[" + std::to_string(row) + "]"; }

void check_labels(const char* key, std::size_t size, Eigen::Index rows) {
  if (size != 0 && size != static_cast<std::size_t>(rows))
    throw ValueError(key, std::to_string(size) + " entries",
                     "one for each of the " + std::to_string(rows) + " rows, or none");
}

void check_noise(double fraction) {
  if (!(fraction >= 0) || !std::isfinite(fraction))
    throw ValueError("noise", std::to_string(fraction), "finite and at least 0");
}

template <class T>
std::vector<T> repeated(const std::vector<T>& values, int copies) {
  std::vector<T> all;
  all.reserve(values.size() * static_cast<std::size_t>(copies));
  for (int copy = 0; copy < copies; ++copy) all.insert(all.end(), values.begin(), values.end());
  return all;
}

// Two normal numbers from two words (Box and Muller 1958); the words become the middles of 2^32 cells of (0, 1).
std::array<double, 2> normal_pair(std::uint32_t a, std::uint32_t b) {
  const double radius = std::sqrt(-2.0 * std::log((a + 0.5) * 0x1p-32));
  const double angle = 2.0 * std::numbers::pi * (b + 0.5) * 0x1p-32;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace

float FrameSet::largest_stress() const {
  return frames.size() == 0 ? 0.0f : frames.leftCols(stresses()).cwiseAbs().maxCoeff();
}

void FrameSet::validate() const {
  if (rows() < 1) throw ValueError("inputs", "no rows", "at least one row");
  if (slip_index.size() != rows())
    throw ValueError("slip_index", std::to_string(slip_index.size()) + " entries",
                     "one for each of the " + std::to_string(rows()) + " rows");
  check_labels("shape_class", shape_class.size(), rows());
  check_labels("contact_nodes", contact_nodes.size(), rows());
  check_labels("torque", torque.size(), rows());
  const bool all_finite = (frames.array() * 0.0f).sum() == 0.0f;  // in vectors; NaN else
  for (Eigen::Index row = 0; row < rows(); ++row) {
    if (!all_finite && !frames.row(row).allFinite()) throw ValueError(at("inputs", row), "NaN or infinity", "finite");
    if (!(std::abs(slip_index(row)) <= largest_slip_index))
      throw ValueError(at("slip_index", row), std::to_string(slip_index(row)), "finite, usually 0 to 1");
  }
}

std::vector<float> peaks(const FrameSet& set) {
  std::vector<float> all(static_cast<std::size_t>(set.rows()));
  const Eigen::Index normals = set.stresses() / (set.axes * set.history);
  for (Eigen::Index row = 0; row < set.rows(); ++row)
    all[static_cast<std::size_t>(row)] = set.frames.row(row).head(normals).cwiseAbs().maxCoeff();
  return all;
}

namespace {

/// The peaks of rows that carry a stress, in ascending order.
std::vector<float> touching_peaks(const FrameSet& set) {
  std::vector<float> touching = peaks(set);
  std::erase_if(touching, [](float peak) { return !(peak >= InputScaling::smallest_stress); });
  std::ranges::sort(touching);
  return touching;
}

}  // namespace

InputScaling fit_scaling(ScalingKind kind, const FrameSet& set, Features features) {
  InputScaling scaling{kind, kind == ScalingKind::set ? set.largest_stress() : 1.0f, set.history, set.axes, features};
  if (features != Features::frame) {
    if (set.columns < 1) throw ValueError("features", name(features), "frame for a set without places of its tactels");
    scaling.columns = set.columns, scaling.square = set.square;
    const std::vector<float> touching = touching_peaks(set);
    if (!touching.empty()) scaling.usual_stress = touching[touching.size() / 2];
  }
  scaling.friction = set.told > 0, scaling.markers = set.markers;
  scaling.validate();
  return scaling;
}

Learnt learnt_ranges(const FrameSet& set) {
  Learnt learnt;
  const std::vector<float> touching = set.markers ? std::vector<float>() : touching_peaks(set);
  if (!touching.empty()) learnt.smallest_peak = touching[touching.size() / 100], learnt.largest_peak = touching.back();
  std::vector<float> friction = set.friction;
  std::erase_if(friction, [](float mu) { return !std::isfinite(mu); });  // bonded contacts have none
  if (!friction.empty()) {
    const auto [least, most] = std::ranges::minmax(friction);
    learnt.least_friction = least, learnt.most_friction = most;
  }
  return learnt;
}

namespace {

/// The row that a row's rest is taken from; `first`: with which its contact begins. P: [rows].
std::size_t rest_of(const FrameSet& set, const std::vector<float>& P, std::size_t first, std::size_t row) {
  const auto rests = [&](std::size_t i) {
    return std::abs(set.slip[i]) < most_slip_at_rest && 2 * P[i] >= P[row] && P[i] <= 2 * P[row];
  };
  std::vector<std::size_t> possible;
  for (std::size_t i = first; i < row; ++i)
    if (rests(i)) possible.push_back(i);
  if (possible.empty()) return row;
  const std::uint64_t word = noise_words(set.contact[row], set.step[row])[0];
  return possible[static_cast<std::size_t>(word * possible.size() >> 32)];
}

void check_history(const FrameSet& set, const InputHistory& history) {
  const auto rows = static_cast<std::size_t>(set.rows());
  const bool ordered = set.history == 1 && set.contact.size() == rows && set.step.size() == rows;
  if (history.path() > 1 && !(set.press_rows && ordered))
    throw ValueError("history", std::to_string(history.path()),
                     "1 for a set without the rows of its pressing; [sweep] press_rows = true gives them");
  if (history.rest && !(ordered && set.slip.size() == rows))
    throw ValueError("scaling", "rest", "set or frame for rows without contact, step or S");
  if (history.friction && !(ordered && set.friction.size() == rows))
    throw ValueError("friction", "given", "left out for rows without contact, step or friction");
}

/// What is told to a row of its mu: a number and its spread.
std::array<float, 2> told_friction(const FrameSet& set, std::size_t row, std::optional<double> spread) {
  const PhiloxCounter words = noise_words(set.contact[row], set.step[row]);
  const float mu = set.friction[row];
  const bool drawn = !spread, silent = drawn ? words[1] % 4 == 0 : std::isinf(*spread);
  if (silent || !std::isfinite(mu) || !(mu > 0)) return {0, 0};
  if (drawn) spread = least_told * std::pow(most_told / least_told, (words[1] >> 2) * 0x1p-30);
  const double normal = normal_pair(words[2], words[3])[0];
  return {static_cast<float>(mu * std::exp(*spread * normal)), static_cast<float>(*spread)};
}

}  // namespace

FrameSet with_history(const FrameSet& set, const InputHistory& history, std::optional<double> spread) {
  if (history.frames == 1 && !history.friction) return set;
  check_history(set, history);
  const auto rows = static_cast<std::size_t>(set.rows());
  const Eigen::Index width = set.frames.cols();
  FrameSet formed = set;
  formed.history = history.frames, formed.told = history.friction ? 2 : 0;
  formed.frames.resize(set.rows(), width * history.frames + formed.told);
  std::vector<float> P(rows);
  for (std::size_t row = 0; row < rows && history.rest; ++row)
    P[row] = -set.frames.row(static_cast<Eigen::Index>(row)).head(width / set.axes).sum();
  FrameHistory path(static_cast<std::size_t>(width), history);
  std::size_t first = 0;  // row of a contact
  for (std::size_t row = 0; row < rows; ++row) {
    const bool follows = row > 0 && set.contact[row] == set.contact[row - 1] && set.step[row] == set.step[row - 1] + 1;
    if (!follows) path.clear(), first = row;
    path.push(set.frames.row(static_cast<Eigen::Index>(row)).data());
    auto input = formed.frames.row(static_cast<Eigen::Index>(row));
    path.write(input.data());
    if (history.friction) {
      const auto [mu, deviation] = told_friction(set, row, spread);
      input.tail(2) << mu, deviation;
    }
    if (!history.rest) continue;
    const std::size_t rest = rest_of(set, P, first, row);
    input.segment(width * history.path(), width) = set.frames.row(static_cast<Eigen::Index>(rest));
    if (!set.slid.empty())
      formed.slip_index(static_cast<Eigen::Index>(row)) =
          slid_target(std::hypot(set.slid[row][0] - set.slid[rest][0], set.slid[row][1] - set.slid[rest][1]));
  }
  return formed;
}

void take_differences(RowMatrix<float>& frames, int history) {
  const Eigen::Index width = frames.cols() / history;
  for (int k = 1; k < history; ++k) frames.middleCols(k * width, width) -= frames.leftCols(width);
}

namespace {

/// `words_of(quad)`: the words of values 4 quad ... 4 quad + 3.
void add_normals(std::span<float> values, double deviation, std::uint64_t first, const auto& words_of) {
  std::array<double, 4> normal{};
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::uint64_t i = first + k;
    if (k == 0 || i % 4 == 0) {
      const PhiloxCounter words = words_of(i / 4);
      const auto [n0, n1] = normal_pair(words[0], words[1]);
      const auto [n2, n3] = normal_pair(words[2], words[3]);
      normal = {n0, n1, n2, n3};
    }
    values[k] += static_cast<float>(deviation * normal[i % 4]);
  }
}

}  // namespace

void add_noise(std::span<float> values, double deviation, std::uint64_t seed, std::uint64_t first) {
  add_normals(values, deviation, first, [seed](std::uint64_t quad) { return noise_words(seed, quad); });
}

void add_pixel_noise(std::span<float> pixels, double deviation, std::uint64_t seed, std::uint64_t contact,
                     std::uint32_t step) {
  const std::uint64_t quads = (pixels.size() + 3) / 4;
  add_normals(pixels, deviation, 0, [&](std::uint64_t quad) {
    return philox4x32(
        {static_cast<std::uint32_t>(contact), static_cast<std::uint32_t>(contact >> 32),
         static_cast<std::uint32_t>(RandomStream::pixel), static_cast<std::uint32_t>(step * quads + quad)},
        {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  });
}

FrameSet with_noise(const FrameSet& set, double fraction, std::uint64_t seed) {
  check_noise(fraction);
  FrameSet noisy = set;
  const double deviation = fraction * set.largest_stress();
  if (deviation == 0) return noisy;
  const auto stresses = static_cast<std::size_t>(noisy.stresses());
  for (Eigen::Index row = 0; row < noisy.rows(); ++row)
    add_noise({noisy.frames.row(row).data(), stresses}, deviation, seed, static_cast<std::uint64_t>(row) * stresses);
  return noisy;
}

FrameSet with_frame_noise(const FrameSet& set, double fraction, std::uint64_t seed, int copies) {
  check_noise(fraction);
  if (copies < 1) throw ValueError("copies", std::to_string(copies), "at least 1");
  FrameSet noisy{.frames = set.frames.replicate(copies, 1),
                 .slip_index = set.slip_index.replicate(copies, 1),
                 .shape_class = repeated(set.shape_class, copies),
                 .contact_nodes = repeated(set.contact_nodes, copies),
                 .torque = repeated(set.torque, copies),
                 .axes = set.axes,
                 .columns = set.columns,
                 .square = set.square};
  const Eigen::Index inputs = set.frames.cols();
  for (Eigen::Index row = 0; row < noisy.rows(); ++row) {
    auto frame = noisy.frames.row(row);
    const double deviation = fraction * frame.cwiseAbs().maxCoeff();
    add_noise({frame.data(), static_cast<std::size_t>(inputs)}, deviation, seed,
              static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(inputs));
  }
  return noisy;
}

}  // namespace tactel::nn
