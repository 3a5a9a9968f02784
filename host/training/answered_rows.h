// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/sets/contact_set.h"

namespace tactel::host {

inline constexpr std::uint8_t over_tolerance = 2;  ///< LaneStatus, as in the set's file

/// The rows of a set for training or judging networks: solved within tolerance, with a slippage index.
struct AnsweredRows {
  nn::FrameSet frames;           ///< with the target in the place of S
  std::vector<std::size_t> row;  ///< [frames.rows()] row of the set
  std::size_t left_out = 0;
  nn::Target target = nn::Target::slip_index;
};

/// Returns the dataset that networks of stresses or of markers do not read, and the numbers of a frame of theirs.
inline const char* unread(bool markers) { return markers ? "inputs" : "markers"; }
inline int frame_inputs(const SetColumns& set, bool markers) {
  return markers ? set.marker_numbers / 3 * 2 : set.inputs;
}
/// Returns the frames of all rows, [rows][frame_inputs].
std::vector<float> frames_of(const ContactSet& set, bool markers);
/// Throws ConfigError naming `file` and a dataset that training and judging need and that the set has not.
void require_answers(const SetColumns& columns, const std::string& file, nn::Target target = nn::Target::slip_index,
                     bool markers = false);
/// Returns none where no row has an answer. markers: frames are x and y of /markers.
AnsweredRows find_answered_rows(const ContactSet& set, nn::Target target = nn::Target::slip_index,
                                bool markers = false);
/// The same; throws ConfigError naming `file` when no row is left.
AnsweredRows answered_rows(const ContactSet& set, const std::string& file, nn::Target target = nn::Target::slip_index,
                           bool markers = false);

/// Returns the rows as a network takes them: with history (nn::with_history, also for `spread`), and with |S| in place
/// of S for `magnitude`. Throws ConfigError naming `file` for rows that no history can be formed from.
nn::FrameSet shown_rows(const nn::FrameSet& rows, const nn::InputHistory& history, bool magnitude,
                        const std::string& file, std::optional<double> spread = {});

/// Throws ConfigError naming `file` and its row for a frame or slippage index that no network can learn from.
/// `first_row`: the file's row that the set begins with.
void check_learnable(const AnsweredRows& rows, const std::string& file, std::uint64_t first_row = 0);

}  // namespace tactel::host
