// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/error.h>
#include <tactel/export.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tactel {

/// Status of the answer to a frame. No answer with status `ok` is NaN.
enum class AnswerStatus : std::uint32_t {
  ok = 0,
  no_stress = 1,   ///< the frame has no normal stress, and the network scales by frame, or its rest has none; the
                   ///< network received zeros
  not_finite = 2,  ///< the frame contains NaN or infinity
  overflow = 3,    ///< the frame is finite, but a sum inside the network is not
  wrong_size = 4,  ///< the frame has not SlipEstimator::inputs() numbers
};

/// Returns "ok", "no stress", "not finite", "overflow" or "wrong size".
TACTEL_API const char* name(AnswerStatus status) noexcept;

/// The answer to a frame. Later versions may give a meaning to `reserved`, and change nothing else.
struct Answer {
  float slip_index;  ///< S, or what metadata("target") names, 0..1; NaN where the status is not_finite, overflow or
                     ///< wrong_size
  float slip_upper;  ///< upper bound of S, at most 1; NaN where the network has none
  AnswerStatus status;
  float slip_interval[2];       ///< S is within it, lower end first; NaN where the network has no bound
  std::uint32_t unlike;         ///< 1: the frame is unlike those of the learning set: the network cannot tell
  std::uint32_t beyond_learnt;  ///< 1: a normal stress is above 10 times the largest that was learnt: are they MPa?
  std::uint32_t reserved[1];    ///< 0
};

/// A network that reads the slippage index S = Q / (mu P) from the stresses at the tactels.
///
/// Answers are equal bit for bit on every processor and in any rounding mode, and equal to those of `tactel monitor` in
/// fp32. An object never changes: threads may share it. Copies are cheap and share the network.
class TACTEL_API SlipEstimator {
 public:
  /// Loads a network file (ONNX) that tactel wrote, or a network of the library by its name, "uskin-4x4". Throws
  /// InputError where the file cannot be read, is damaged, or holds another graph.
  static SlipEstimator load(const std::string& path);
  /// The same from the bytes of a file; errors name `place`.
  static SlipEstimator parse(std::span<const std::byte> bytes, const std::string& place = "network");

  ~SlipEstimator();
  SlipEstimator(const SlipEstimator&) noexcept;
  SlipEstimator& operator=(const SlipEstimator&) noexcept;

  /// Returns the numbers of an input: a normal and a shear stress for each tactel, in each of frames() frames, and what
  /// takes_friction().
  std::size_t inputs() const noexcept;
  /// Returns the frames of an input: 1, or those of `tactel train --history`, the newest first, and behind them the
  /// rest where needs_rest(). SlipHistory gathers them.
  std::size_t frames() const noexcept;
  /// Returns the tactels: of each frame so many numbers, the first, are normal stresses.
  std::size_t tactels() const noexcept;
  /// Returns whether answers have an upper bound and an interval of S.
  bool has_bound() const noexcept;
  /// Returns MPa: 1 % of the learnt frames had a smaller largest normal stress. 0 where the file does not know it.
  float smallest_peak() const noexcept;
  /// Returns whether the network reads changes since the grip was at rest (`tactel train --scaling rest`).
  bool needs_rest() const noexcept;
  /// Returns whether the network takes what is known of friction (`tactel train --friction`): the last two numbers of
  /// an input are mu, 0 where it is not known, and its relative standard deviation.
  bool takes_friction() const noexcept;
  /// Returns the threshold of an alarm that the file of a network of `slid` has (`tactel train --alarm-at`). 0: none.
  float alarm_at() const noexcept;

  /// Returns S of one frame: [inputs] MPa, the normal stresses of all tactels first, then the shear stresses. At the
  /// base sigma_y < 0 is compression; tau_xy > 0 where the indenter drags the rubber toward +x. Allocates nothing,
  /// takes no lock and throws nothing. A frame of noise alone has an answer, too: the caller decides by the largest
  /// normal stress whether anything touches. Its time depends on the network alone: 0.2 us for 42-42-21-1
  /// (bench/README.md).
  Answer estimate(std::span<const float> frame) const noexcept;

  /// Estimates frames [answers, inputs] in the calling thread: 0.1 us each for 42-42-21-1, with the bits of one frame
  /// alone. Returns the number of answers written: `answers.size()`, or 0 where `frames` is of another size. Allocates
  /// nothing.
  std::size_t estimate(std::span<const float> frames, std::span<Answer> answers) const noexcept;

  /// Returns the widths of the layers, "42-42-21-1".
  std::string topology() const;
  /// Returns an entry of the file: "seed", "noise", "learning_set", "error_mean", "target", ...; empty where the file
  /// has none. "inputs" is "markers" where a frame is x and y of every marker, mm, not stresses.
  std::string metadata(std::string_view key) const;

  struct Network;

 private:
  friend class SlipHistory;
  explicit SlipEstimator(const Network* network) noexcept : network_(network) {}
  const Network* network_;  ///< counts its owners
};

/// The frames of one sensor, one after the other, for a network with history: it keeps the frames that the network's
/// input takes, by change of load (docs/networks.md), and the rest of the grip as Alarm finds it. A network of one
/// frame answers as by itself. Each sensor needs its own object; an object is for one thread at a time.
class TACTEL_API SlipHistory {
 public:
  /// Allocates all memory that estimate() needs.
  explicit SlipHistory(const SlipEstimator& network);
  /// touch: MPa, as of AlarmOptions, for the rest.
  SlipHistory(const SlipEstimator& network, std::optional<double> touch);
  ~SlipHistory();
  SlipHistory(const SlipHistory&) = delete;
  SlipHistory& operator=(const SlipHistory&) = delete;

  /// Returns the numbers of one frame: a normal and a shear stress for each tactel.
  std::size_t inputs() const noexcept;
  /// Takes the sensor's next frame [inputs] MPa and returns S. Every frame of the sensor must pass, at any rate.
  /// Allocates nothing, takes no lock and throws nothing.
  Answer estimate(std::span<const float> frame) noexcept;
  /// Tells a network that takes friction mu, above 0, and its relative standard deviation, 0 or more; 0: mu is not
  /// known, as in the beginning.
  void friction(float mu, float spread) noexcept;
  /// Call it where the object is known to slide in the newest frame, as under a robot that moves while frames stand
  /// still: reads mu from that frame, tells it with a spread of 0.15 from the next one on, and returns it. mu is the
  /// largest for which the network, told it within 5 %, reads an S of 0.97 or more; of several calls the geometric
  /// mean, until friction() tells another. NaN, and nothing is told: the network takes no friction, or the frame has no
  /// answer.
  float slides() noexcept;
  /// Seeks the rest anew from the next frame on.
  void rest() noexcept;
  /// Forgets all frames: the next one begins a contact.
  void clear() noexcept;

 private:
  struct State;
  State* state_;
};

/// The number that an Alarm judges.
enum class AlarmSignal : std::uint32_t {
  slip = 0,   ///< the upper bound of S, or S; of a network of `slid` its answer
  moved = 1,  ///< AlarmAnswer::moved
  left = 2,   ///< AlarmAnswer::left
};

/// Why a frame cannot tell.
enum class CannotTell : std::uint32_t {
  none = 0,
  not_a_number = 1,  ///< a stress is NaN or infinite
  frozen = 2,        ///< no stress has changed for more than twice as many frames as ever before, and for ten at least
  wrong_sign = 3,    ///< the normal stresses pull
  no_rest = 4,       ///< the rest that it needs is not found
  unlike = 5,        ///< it is unlike those that the network learnt
  wide = 6,          ///< only the width of the interval keeps the alarm off
  no_answer = 7,     ///< the network has none
};

/// Returns "not a number", "frozen", "wrong sign", "no rest", "unlike", "wide interval" or "no answer"; "" of none.
TACTEL_API const char* name(CannotTell why) noexcept;

/// How a hand trembles that holds, as `tactel tare --hold` writes it into [hold] of a calibration file.
struct HeldGrip {
  /// Lower triangle, row by row, of the covariance of the moments of the changes since rest, over P: Q_x, Q_y, z x, z
  /// y, tau_x x, tau_x y, tau_y x, tau_y y, of tactels' places over their rms radius. Normal stresses alone have z x, z
  /// y.
  std::array<float, 36> covariance{};
  float at = 0;  ///< threshold of their norm by it; 0: no hold was recorded
};

/// Rules of an Alarm.
struct AlarmOptions {
  /// The alarm begins where the upper bound of S (S itself of a network without a bound) reaches this, 0 to 1, and ends
  /// below at - 0.05. Of AlarmSignal::moved: above 0 and below 0.5, such as 1.2 times the largest `moved` of a hold
  /// that holds (`tactel tare --hold`); it ends below at / 1.2, as that of a network of `slid` does. Infinity: it never
  /// begins. -1: of AlarmSignal::left 1; else alarm_at() of the network, and 0.8 where it has none.
  float at = -1;
  /// MPa: a frame whose normal stresses all stay below this is no contact. It has no S, and ends an alarm. None:
  /// smallest_peak() of the network, 0.001 without one. 0: every frame is one, and noise at rest raises alarms.
  std::optional<double> touch{};
  /// No alarm begins at a frame whose interval of S is wider than this: it cannot tell.
  float widest = std::numeric_limits<float>::infinity();
  /// The alarm begins at the last of so many frames in a row of which each asks for it; 1 or more.
  int hold = 1;
  /// A frame that is `unlike` asks for the alarm, as the network cannot tell. True: its S decides.
  bool ignore_unlike = false;
  /// Answers have `rest` and `moved`; needs a threshold of touch above 0. A network with needs_rest() stands for it.
  bool rest = false;
  /// moved, left: need no network, and stand for `rest`, too.
  AlarmSignal signal = AlarmSignal::slip;
  /// Of AlarmSignal::left: Hz, of the frames; tactels along x of a pad, x fastest, 0: as many as along y; pitch along y
  /// over that along x; a recorded hold; Q / P with its torque of a slide (`tactel tare --slide`), 0: none is known.
  double rate = 60;
  std::size_t columns = 0;
  double aspect = 1;
  HeldGrip held{};
  float slide = 0;
};

/// What an Alarm says about a frame.
struct AlarmAnswer {
  Answer answer{};                ///< its S and upper bound are NaN without contact
  std::optional<bool> contact{};  ///< none without a threshold of touch
  float acted_on = 0;        ///< number that the alarm judges, AlarmSignal; 0 without contact, or rest where needed
  bool on = false;           ///< the alarm
  bool cannot_tell = false;  ///< by `why`. The alarm stays as it is, or goes by what `left` makes of the other stresses
  std::optional<bool> rest{};  ///< whether a rest of this grip is known; none where it is not asked for
  /// Change of the stresses since rest: the Euclidean norm of the differences of all, over the sum of the normal
  /// stresses at rest. NaN without contact or rest, and where a stress is not finite.
  float moved = std::numeric_limits<float>::quiet_NaN();
  CannotTell why = CannotTell::none;
  /// Of AlarmSignal::left. How far the stresses have left their rest, 1: the alarm; squeezing and easing leave it at 0.
  /// NaN without contact or rest. It is the larger of `score`, of the patterns of pressure and shear, and `of_hold`, of
  /// the moments by a recorded hold; judge() takes `index` into it.
  float left = std::numeric_limits<float>::quiet_NaN(), score = left, of_hold = left;
  /// How the hand trembles at rest: the rms distance of frames from their mean, over P.
  float calm = std::numeric_limits<float>::quiet_NaN();
  /// Q / P with its torque, over that of a slide: 1 slides. NaN without contact, or where none is known.
  float index = std::numeric_limits<float>::quiet_NaN();
  bool released = false;  ///< the hand opens, or has opened: no alarm begins
};

/// Gives the answers of the pads that hold one object, before judge(), what they say together: of `score` 0.35 of the
/// largest and 0.65 of the smallest, as an object leaves all pads, the largest `of_hold` and the smallest `index`.
TACTEL_API void join(std::span<AlarmAnswer> pads) noexcept;

/// The alarm of `tactel monitor`: its frames of one sensor in turn, by its rules. A frame without an answer leaves the
/// alarm as it is. Each of several sensors has its Alarm: there is one where one of them is on. An object is for one
/// thread at a time.
///
/// Rest is the mean of the first frames after touch-down in which nothing moves: ten or more, and a quarter of those
/// since touch-down; 500 are enough. It is sought anew after a release, where the sum of the normal stresses has
/// doubled, and by rest(). That of AlarmSignal::left follows the hand: it is the mean of the last third of a second in
/// which the hand moved no more than its tremor. What leaves it more slowly than by a tenth of P a second is not seen.
class TACTEL_API Alarm {
 public:
  /// Throws InputError for options out of range, `widest` without a bound, and a network that estimates neither S nor
  /// `slid`.
  explicit Alarm(const SlipEstimator& network, const AlarmOptions& options = {});
  /// Without a network, by AlarmSignal::moved or left: frames of 1 or more tactels with 1 to 3 axes each, normal
  /// stresses first. S and its bound are NaN. Throws InputError for options out of range.
  Alarm(std::size_t tactels, std::size_t axes, const AlarmOptions& options);
  ~Alarm();
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  /// Returns the numbers of one frame, in the order of SlipEstimator::estimate.
  std::size_t inputs() const noexcept;
  /// Takes the sensor's next frame [inputs] MPa. Allocates nothing, takes no lock and throws nothing.
  AlarmAnswer next(std::span<const float> frame) noexcept { return judge(answer(frame)); }

  /// The two parts of next(). answer() gives S and contact and leaves the alarm, as for frames that come too late.
  AlarmAnswer answer(std::span<const float> frame) noexcept;
  /// The same for an answer that was estimated elsewhere, as on a device: takes no frame into its own history.
  AlarmAnswer answer(std::span<const float> frame, const Answer& estimated) noexcept;
  AlarmAnswer judge(AlarmAnswer answer) noexcept;
  /// As SlipHistory::friction. Throws InputError for numbers out of range and a network that does not take friction.
  void friction(double mu, double spread);
  /// As SlipHistory::slides, of the newest frame that next() took. Of AlarmSignal::left: remembers Q / P with
  /// its torque for `index`, the median of the last third of a second that touches, and returns it.
  float slides() noexcept;
  /// Says that frames come at another rate, Hz, than that of the options. Ignores what is no number above 0.
  void rate(double hz) noexcept;
  /// Seeks rest anew from the next frame on: call it where the hand has changed its grip and holds still. Ends an alarm
  /// that needs the rest.
  void rest() noexcept;
  /// Ends the alarm and forgets all frames.
  void clear() noexcept;

 private:
  struct State;
  State* state_;
};

/// Returns the version of the library, "1.0.0-rc1".
TACTEL_API const char* version() noexcept;

}  // namespace tactel
