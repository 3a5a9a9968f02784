// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hw/channel_map.h"
#include "hw/tare.h"

namespace tactel::host {

/// Channels that no longer fit offsets and noise of the calibration, found at once.
struct Drift {
  enum class Kind {
    offset,   ///< the mean at rest moved from the offset
    noise,    ///< the noise at rest grew
    stuck,    ///< the reading does not change
    mounting  ///< a pad's shear does not fit its tactels' places (MountingWatch)
  };
  Kind kind;
  std::vector<int> channels;  ///< of the device, the worst first
  double size = 0;   ///< of the worst: shift over noise, noise over that of the calibration, s without a change, fit
  std::string text;  ///< a sentence: what was found, and the remedy
  const char* name() const;    ///< "offset", "noise", "stuck", "mounting"
  const char* advice() const;  ///< in a few words
};

/// Compares frames at rest with offsets and noise of a calibration, and names each channel and kind once.
///
/// The rest is cut into blocks of some s, of 64 frames at least. A block is judged where the sensor rested during the
/// block before and the one after it, so that the beginning and the end of a touch are not taken for rest. Fewer than
/// three frames in contact in a row are rest. A channel
/// that moved within its block is not judged. An offset moved where the mean of a block is farther than one standard
/// deviation of the noise from it (or one and a half steps of the readings, where these are larger), and noise grew
/// where it is twice that. The mean of n readings of white noise exceeds one deviation with the probability erfc(sqrt(n
/// / 2)): 1e-15 for 64 frames. A channel is stuck where its reading is the same for five blocks and 320 frames, in
/// contact or not, though its noise shows in the readings. A pause of the frames counts as one block at most.
class DriftWatch {
 public:
  static constexpr std::size_t least_frames = 64;  ///< of a block
  static constexpr double stuck_blocks = 5;

  /// `block`: s, of which twice the time constant of charge amplifiers is the least. `most_shift` of an offset, in
  /// standard deviations of the noise. A calibration without noise leaves nothing to watch.
  DriftWatch(const hw::ChannelMap& map, double block, double most_shift = 1);

  /// Takes the next frame [map.places()] MPa, its contact and arrival in s. Returns what it completes: mostly nothing.
  std::vector<Drift> next(std::span<const float> frame, bool contact, double arrival);

 private:
  struct Input {
    int channel;
    std::string name;
    double gain, noise;      ///< MPa by the device's unit; the device's unit
    double last, last_time;  ///< reading less offset and the time of its last change
    bool told[3];            ///< by Drift::Kind
    std::size_t same;        ///< frames since its last change
  };
  struct Finding {
    std::size_t input;
    double size;
  };

  void read(std::span<const float> frame, double arrival);
  void judge(const hw::Tare& block, std::vector<Drift>& found);
  void find_stuck(double arrival, std::vector<Drift>& found);
  void tell(Drift::Kind kind, std::vector<Finding> findings, std::vector<Drift>& found);

  double block_, most_shift_;
  std::vector<Input> inputs_;           ///< those with a channel, a gain and a known noise
  std::vector<std::size_t> places_;     ///< [inputs] in a frame
  std::vector<double> readings_;        ///< scratch, [inputs]: less the offset, the device's units
  double step_ = 0;                     ///< smallest change of any channel so far, the device's units; 0: none yet
  std::optional<hw::Tare> now_, last_;  ///< block that is being filled, and the one before it, both at rest
  int touching_ = 0;                    ///< frames in contact in a row
  bool rested_ = false;                 ///< before last_, too
  std::optional<double> begin_;         ///< s, of the block that is being filled
  double next_check_ = 0;               ///< s, of stuck channels
  std::optional<double> last_arrival_;  ///< s
};

}  // namespace tactel::host
