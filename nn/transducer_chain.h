// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "nn/model.h"

namespace tactel::nn {

/// Measuring chain from the stress at a transducer to its reading, in this order. A part whose numbers are 0 is
/// not applied.
struct Transducer {
  double gain_spread = 0;       ///< standard deviation of a transducer's gain, about 1
  double time_constant = 0;     ///< s, RC of the charge amplifier: a high-pass of first order, at rest before step 0
  double step_time = 0;         ///< s between load steps; the stress is linear in between
  double offset_spread = 0;     ///< MPa, standard deviation of an amplifier's offset, about 0
  double noise = 0;             ///< MPa, standard deviation, drawn anew for every reading
  double range = 0;             ///< MPa: readings beyond -range ... range are clipped
  int bits = 0;                 ///< of the conversion: 2^bits readings from -range up to one step below range
  std::uint32_t instances = 0;  ///< number of sensors, one of which each contact meets; 0: one for each contact
  std::uint64_t seed = 0;       ///< of gains, offsets and their assignment; noise uses the seed of the set

  double noise_of_largest = 0;  ///< standard deviation over the largest |stress| of the contact; added to `noise`
  double shift_spread = 0;      ///< standard deviation of a tactel's place, over the distance of two tactels
  double crosstalk =
      0;            ///< size of the share that each neighbour's stress has in a reading: |normal|, this its deviation
  double dead = 0;  ///< probability that a transducer does not feel its stress
  double lag = 0;   ///< share of the stress that arrives late: slow hysteresis of the rubber
  double lag_time = 0;  ///< s, time constant of that share
  /// Smallest gain_spread, offset_spread and noise: a sensor's own lies evenly between it and the member above. None:
  /// all sensors have that.
  std::optional<double> gain_spread_from{}, offset_spread_from{}, noise_from{};
  std::optional<double> time_constant_from{};  ///< s, smallest time_constant, alike
  std::optional<int> bits_from{};              ///< fewest bits: a sensor has one of the whole numbers up to `bits`

  bool operator==(const Transducer&) const = default;
  bool present() const;   ///< true where any part is applied
  void validate() const;  ///< throws ValueError, key "transducer.<member>"
  /// Returns true where a reading depends on the stresses of neighbours.
  bool reaches_neighbours() const { return shift_spread > 0 || crosstalk > 0; }
  /// Returns the MPa between two readings; 0 without conversion.
  double quantum() const;
};

/// Returns the members that are not 0, with their units: "gain_spread 0.1, noise 0.01 MPa"; "none".
std::string description(const Transducer& transducer);

/// Returns the readings of one contact, in double precision: the twin of kernels/transducer_chain.cl. stress:
/// [load steps, channels] MPa, normal stresses of all tactels first, then shear; all steps of the contact from
/// the first on. Random numbers are functions of the seeds, contact, step and channel, as
/// kernels/transducer_chain.cl defines.
RowMatrix<double> transducer_chain(const Transducer& transducer, std::uint64_t seed, std::uint64_t contact,
                                   const RowMatrix<double>& stress);

}  // namespace tactel::nn
