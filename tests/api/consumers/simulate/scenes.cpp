// SPDX-License-Identifier: Apache-2.0

// A scene, many scenes, a sweep, a network and a stream: scenes SCENE.toml SWEEP.toml.
#include <poll.h>
#include <tactel/live.h>
#include <tactel/simulate.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

namespace {

int failures = 0;

void check(bool met, const char* what) {
  if (!met) std::fprintf(stderr, "not so: %s\n", what), ++failures;
}

/// Frames of a mark and two readings as 16-bit numbers.
class Pairs : public tactel::WireFormat {
 public:
  tactel::Verdict inspect(std::span<const std::uint8_t> bytes) const override {
    if (bytes[0] != 0xA5) return {tactel::Verdict::nothing, 0};
    return bytes.size() < 5 ? tactel::Verdict{} : tactel::Verdict{tactel::Verdict::whole, 5};
  }
  tactel::FrameHeader read(std::span<const std::uint8_t> frame, std::span<double> values) const override {
    for (int i = 0; i < 2; ++i) values[i] = frame[1 + 2 * i] + 256 * frame[2 + 2 * i];
    return {};
  }
  std::size_t channels() const override { return 2; }
  std::size_t longest_frame() const override { return 5; }
};

/// A descriptor as a source of bytes.
class Descriptor : public tactel::ByteSource {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  int fd() const override { return fd_; }

 private:
  int fd_;
};

void check_stream() {
  int ends[2];
  check(::pipe(ends) == 0, "a pipe");
  Descriptor bytes(ends[0]);
  const Pairs format;
  tactel::FrameSource source(bytes, format, {.normal = {0}, .shear = {1}, .offset = {}, .gain = {-0.001, 0.002}});
  tactel::Frame frame;
  check(!source.poll(frame) && !source.finished(), "no frame yet");
  const std::uint8_t sent[] = {0xA5, 100, 0, 0, 1, 0xA5, 1, 0, 2, 0};
  check(::write(ends[1], sent, sizeof sent) == sizeof sent, "bytes sent");
  pollfd wanted{source.fd(), POLLIN, 0};
  check(::poll(&wanted, 1, 1000) == 1, "the descriptor is readable");
  check(source.poll(frame) && std::abs(frame.stress[0] + 0.1f) < 1e-6f && std::abs(frame.stress[1] - 0.512f) < 1e-6f,
        "(reading - offset) gain");
  check(source.poll(frame) && frame.number == 1 && !source.poll(frame), "two frames, then none");
  ::close(ends[1]);
  check(!source.wait(frame, 1) && source.finished() && source.counts().frames == 2, "the end of a closed pipe");
  ::close(ends[0]);
}

}  // namespace

int main(int, char** words) try {
  const tactel::Scene read = tactel::read_scene(words[1]);
  const tactel::Path path = tactel::solve(read);
  check(!path.steps.empty() && path.steps.back().converged && path.sliding, "the scene slides");
  check(std::abs(path.steps.back().slip_index - 1) < 1e-3, "and S is 1 there");
  std::printf("%s: S = %.4f after %zu steps\n", path.model.c_str(), path.steps.back().slip_index, path.steps.size());

  tactel::Scene scene;
  scene.indenter.shape = tactel::sampled([](double x) { return x * x / 20; }, -6, 6);
  scene.load = tactel::press(0.1).drag(0.05, 4);
  std::vector<tactel::Scene> scenes;
  for (int k = 1; k <= 8; ++k) scenes.push_back(scene), scenes.back().friction = 0.1 * k;
  const tactel::Paths paths = tactel::solve_many(scenes);
  check(paths.scenes == 8 && paths.steps == 5 && paths.tactels == 21, "arrays of the right shape");
  for (std::size_t i = 1; i < paths.scenes; ++i)  // the same drag reaches more of the limit where friction is less
    check(paths.slip_index[i * paths.steps + 1] <= paths.slip_index[(i - 1) * paths.steps + 1] + 1e-3,
          "S falls with mu");

  const tactel::Sweep sweep(words[2], 11);
  const tactel::Set set = sweep.generate(40);
  check(sweep.seed() == 11 && set.rows() > 0 && set.frames.size() == set.rows() * set.inputs, "rows of a sweep");
  tactel::TrainOptions options;
  options.networks = {"42-6-1"}, options.cycles = 3;
  const std::vector<tactel::Network> networks = tactel::train(set, options);
  const tactel::SlipEstimator estimator = networks.at(0).estimator();
  check(tactel::errors(estimator, set).rows == set.rows(), "a network answers every row");

  try {
    scene.sensor.poisson = 0.7;
    tactel::solve(scene);
    check(false, "an impossible scene is an error");
  } catch (const tactel::InputError& error) {
    check(error.place == "sensor.poisson", "the error names the value");
  }
  try {
    tactel::read_scene("no/such/scene.toml");
    check(false, "a missing scene is an error");
  } catch (const tactel::InputError& error) {
    check(std::strstr(error.what(), "no/such/scene.toml") != nullptr, "the error names the file");
  }
  check_stream();
  return failures != 0;
} catch (const tactel::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
