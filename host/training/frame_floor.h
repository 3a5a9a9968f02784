// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/device/executor.h"
#include "host/sets/contact_set.h"
#include "nn/frame_history.h"

namespace tactel::host {

/// Rows of contacts of SourceOf::changed, by contact, then step.
struct ChangedRows {
  int inputs = 0;                             ///< numbers of a frame
  std::uint64_t changes = 1;                  ///< contacts to one of the source
  double shift = 0;                           ///< of a number's range
  std::span<const float> frames, slip_index;  ///< [rows, inputs] MPa; [rows]
  std::span<const std::uint64_t> contact;     ///< [rows]
  std::span<const std::uint32_t> step;        ///< [rows]
  std::span<const std::uint8_t> status;       ///< [rows]
};

/// Readings of unchanged rows.
struct Readings {
  std::vector<std::int64_t> rows;  ///< [readings, frames of a reading], the newest first; -1: zeros
  std::vector<double> sigma;       ///< [readings] MPa, standard deviation of the noise
  double gain = 0;                 ///< standard deviation of the transducers' gains about 1
};

/// Returns the mean of |error of S| of the best reader of each reading, where frames and S are linear in the drawn
/// numbers, each uniform over its range (variance 1/12): sqrt(2 / pi) sd with sd^2 = g' (J' C^-1 J + 12 I)^-1 g, J and
/// g the derivatives of frames and S, C the covariance of noise and gains.
std::vector<double> linear_errors(const ChangedRows& rows, const Readings& readings);

/// The least mean |error of S| that frames allow, estimated by linear_errors on some contacts.
struct FrameFloor {
  double mean = 0, standard_error = 0;
  std::size_t contacts = 0, readings = 0;
  int frames = 1;      ///< of a reading
  double noise = 0;    ///< mean standard deviation over the largest |stress| of the contact; 1e-4 at least
  std::string reason;  ///< why there is no floor; empty where there is one

  /// "these frames allow a mean error of 0.047 at best (floor: +- 0.002 by 626 frames of 32 contacts, noise 1 %)"
  std::string text() const;
};
nlohmann::ordered_json to_json(const FrameFloor& floor);

/// Returns the floor of a set's frames as networks with this history read them: of the first contacts of its sweep,
/// simulated anew without noise and with each drawn number changed. `file` is the set's; files that its sweep names lie
/// beside it.
FrameFloor frame_floor(Executor& executor, const ContactSet& set, const std::string& file,
                       const nn::InputHistory& history);

}  // namespace tactel::host
