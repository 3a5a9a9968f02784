// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "nn/model.h"

namespace tactel::nn {

/// Measuring chain from the stresses s_k [MPa] at a transducer to its readings r_k [MPa], k the load step. A part whose
/// numbers are 0 is not applied. In this order, with the members' names for their numbers, n for normal numbers, and
/// D(x)_k = exp(-h / T) D(x)_{k-1} + (T / h) (1 - exp(-h / T)) (x_k - x_{k-1}), D(x)_{-1} = x_{-1} = 0, h = step_time:
///
///     shift      a_k = s at the shifted place, linear between tactels: shift_spread n of their distance
///     crosstalk  b_k = a_k + crosstalk |n| (s_k of each neighbour)
///     mixing     c_k = b_k + sum over the other axes of the tactel of mixing n (s_k of that axis)
///     dead       c_k = 0 where a uniform number is below dead
///     lag        d_k = c_k - lag D(c)_k [T = lag_time] - memory D(c)_k [T = memory_time]
///     gain       e_k = (1 + gain_spread n) d_k, of shear times shear_gain
///     amplifier  f_k = D(e)_k [T = time_constant]
///     zero       g_k = f_k + offset_spread n + drift n (largest |normal stress| of the contact)
///     noise      i_k = g_k + (noise + noise_of_largest (largest |stress| of the contact)) n_k
///     converter  r_k = i_k cut off at range and rounded to bits
///     repeats    r_k = r_{k-1} in all channels where a uniform number of step k > 0 is below repeats
///
/// A stress held from time 0 reads 1 - lag exp(-t / lag_time) - memory exp(-t / memory_time) of itself at time t. After
/// a long hold the share lag exp(-t / lag_time) + memory exp(-t / memory_time) is left at time t after its end.
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
  double lag_time = 0;     ///< s, time constant of that share
  double memory = 0;       ///< second share that arrives late
  double memory_time = 0;  ///< s, its time constant
  double mixing = 0;       ///< standard deviation of the share of each other axis of a tactel in a reading
  double drift = 0;        ///< of a contact's zero, standard deviation over the largest |normal stress| of the contact
  double repeats = 0;      ///< probability that a frame repeats the one before
  double shear_gain = 0;   ///< gain of a sensor's shear against that of its normal stress; 0: 1
  /// Smallest gain_spread, offset_spread and noise: a sensor's own lies evenly between it and the member above. None:
  /// all sensors have that.
  std::optional<double> gain_spread_from{}, offset_spread_from{}, noise_from{};
  std::optional<double> mixing_from{}, drift_from{}, repeats_from{};  ///< alike
  std::optional<double> shear_gain_from{};  ///< smallest shear_gain: a sensor's logarithm lies evenly between both
  std::optional<double> lag_from{}, lag_time_from{}, memory_from{}, memory_time_from{};  ///< alike
  std::optional<double> time_constant_from{};  ///< s, smallest time_constant, alike
  std::optional<int> bits_from{};              ///< fewest bits: a sensor has one of the whole numbers up to `bits`

  bool operator==(const Transducer&) const = default;
  bool present() const;   ///< true where any part is applied
  void validate() const;  ///< throws ValueError, key "transducer.<member>"
  /// Returns true where a reading depends on the stresses of other channels.
  bool reaches_others() const { return shift_spread > 0 || crosstalk > 0 || mixing > 0; }
  /// Returns the MPa between two readings; 0 without conversion.
  double quantum() const;
};

/// Returns the members that are not 0, with their units: "gain_spread 0.1, noise 0.01 MPa"; "none".
std::string description(const Transducer& transducer);

/// Returns the readings of one contact, in double precision: the twin of kernels/transducer_chain.cl. stress:
/// [load steps, axes x rows x tactels of a row] MPa, the normal axis first; all steps of the contact from the first on.
/// A line has 2 axes, normal and shear, and one row; a pad has 3, z, x and y. Random numbers are functions of the
/// seeds, contact, step and channel, as kernels/transducer_chain.cl defines. Throws std::invalid_argument for channels
/// that are not whole axes and rows.
RowMatrix<double> transducer_chain(const Transducer& transducer, std::uint64_t seed, std::uint64_t contact,
                                   const RowMatrix<double>& stress, int axes = 2, int rows = 1);

}  // namespace tactel::nn
