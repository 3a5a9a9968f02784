#pragma once
#include <cstdint>
#include <string>

#include "nn/model.h"

namespace tactel::nn {

/// What stands between the stress that a transducer feels and the number that a computer reads, in this order; a part
/// whose numbers are 0 is not there.
struct Transducer {
  double gain_spread = 0;       ///< standard deviation of a transducer's gain, about 1
  double time_constant = 0;     ///< s, RC of the charge amplifier: a high-pass of first order, at rest before step 0
  double step_time = 0;         ///< s from one load step to the next; the stress grows evenly in between
  double offset_spread = 0;     ///< MPa, standard deviation of an amplifier's offset, about 0
  double noise = 0;             ///< MPa, standard deviation, anew for every reading
  double range = 0;             ///< MPa: readings beyond -range ... range are cut off
  int bits = 0;                 ///< of the conversion: 2^bits readings from -range up to one step below range
  std::uint32_t instances = 0;  ///< sensors of which each contact meets one; 0: each contact its own
  std::uint64_t seed = 0;       ///< of gains, offsets and who meets whom; noise goes by the set's

  bool operator==(const Transducer&) const = default;
  bool present() const;   ///< whether it changes anything
  void validate() const;  ///< throws ValueError, key "transducer.<member>"
  /// MPa between two readings; 0 without conversion.
  double quantum() const;
};

/// Its members that are not 0, with their units: "gain_spread 0.1, noise 0.01 MPa"; "none".
std::string description(const Transducer& transducer);

/// What is read of one contact, in double precision: the plain twin of kernels/transducer_chain.cl. stress: [load
/// steps, channels] MPa, normal stresses of all tactels first, then shear; all steps of the contact, from the first on.
/// Random numbers are functions of the seeds, contact, step and channel: kernels/transducer_chain.cl says which.
RowMatrix<double> transducer_chain(const Transducer& transducer, std::uint64_t seed, std::uint64_t contact,
                                   const RowMatrix<double>& stress);

}  // namespace tactel::nn
