// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "nn/weights.h"

namespace tactel::nn {

/// How a contact is read: `history` frames of `inputs` transducers, the newest first. Reading m of transducer t is
///   x_mt = (1 + gain e_t) f_mt + sigma n_mt,   sigma = noise max_t |f_0t|
/// with normal numbers e_t (one a transducer and contact: gains do not change along a contact) and n_mt. Functions with
/// a `largest` above 0 [MPa] take it in place of max_t |f_0t|, for a noise over the contact's largest stress.
struct ReadingModel {
  int inputs = 0;    ///< transducers of a frame
  int history = 1;   ///< frames of a reading, at least 1
  double noise = 0;  ///< over the largest |stress| of the newest frame or `largest`, above 0
  double gain = 0;   ///< standard deviation of the gains about 1, at least 0

  int size() const { return inputs * history; }
  void validate() const;  ///< throws ValueError, keys "noise", "gain", "history"
};

/// Returns sigma [MPa] of the frames [history][inputs] MPa of a contact.
double deviation(const ReadingModel& model, std::span<const float> truth, double largest = 0);

/// Returns the logarithm of the density of a reading [history][inputs] MPa of a contact with the frames `truth`,
/// without the constant (2 pi)^(-size/2). Twin of kernels/frame_likelihood.cl. For each transducer the covariance is
/// sigma^2 I + gain^2 f f'; its inverse and determinant are by Sherman, Morrison (1950). sigma must be above 0.
double log_likelihood(const ReadingModel& model, std::span<const float> truth, std::span<const float> reading,
                      double largest = 0);

/// Returns the mean of |error of S| of a reading of `truth`, where S and the frames are linear in `numbers` unknown
/// numbers with independent priors of variance 1 / 12 (uniform over a range of 1): sqrt(2 / pi) sd with sd^2 = g' (J'
/// C^-1 J + 12 I)^-1 g, C the covariance of the reading. J: [size, numbers] MPa and g: [numbers], derivatives of frames
/// and S.
double linear_error(const ReadingModel& model, std::span<const float> truth, const RowMatrix<double>& j,
                    const Vector<double>& g, double largest = 0);

/// Returns readings [rows, size] of contacts with the frames truth [rows, size]. Row i takes normal numbers i size ...
/// of add_noise with `seed`, and its gains from `seed` + 1. A frame of zeros, from before the contact, stays one.
/// largest: [rows] MPa, or empty.
RowMatrix<float> draw_readings(const ReadingModel& model, const RowMatrix<float>& truth, std::uint64_t seed,
                               std::span<const float> largest = {});

}  // namespace tactel::nn
