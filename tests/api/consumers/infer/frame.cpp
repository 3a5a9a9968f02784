// SPDX-License-Identifier: Apache-2.0

// S of one frame and of a batch, and the errors: frame_cpp NETWORK MISSING.
#include <tactel/infer.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <thread>
#include <vector>

namespace {

int failures = 0;

void check(bool met, const char* what) {
  if (!met) std::fprintf(stderr, "not so: %s\n", what), ++failures;
}

/// By value through containers: alignments of another instruction set would break here.
struct Owner {
  char before = 0;
  tactel::SlipEstimator network;
  tactel::Answer answer;
};

}  // namespace

int main(int, char** words) {
  const auto network = tactel::SlipEstimator::load(words[1]);
  std::vector<float> frame(network.inputs());
  for (std::size_t i = 0; i < frame.size(); ++i) frame[i] = 0.05f * static_cast<float>(i + 1);
  const tactel::Answer answer = network.estimate(frame);
  std::printf("%zu inputs, S = %.9g, %s\n", network.inputs(), answer.slip_index, tactel::name(answer.status));
  check(answer.status == tactel::AnswerStatus::ok && answer.slip_index > 0 && answer.slip_index < 1, "S in 0..1");

  std::vector<Owner> owners(100, Owner{0, network, answer});
  owners.insert(owners.begin(), 3, owners.back());
  for (Owner& owner : owners) owner.answer = owner.network.estimate(frame);
  check(owners.back().answer.slip_index == answer.slip_index, "copies answer alike");

  std::vector<float> frames;
  for (int row = 0; row < 10; ++row) frames.insert(frames.end(), frame.begin(), frame.end());
  std::vector<tactel::Answer> answers(10);
  check(network.estimate(frames, answers) == 10 && answers[9].slip_index == answer.slip_index, "a batch");
  frame[0] = NAN;
  check(network.estimate(frame).status == tactel::AnswerStatus::not_finite, "NaN has a status");

  float of_thread = 0;
  std::thread([&] { of_thread = network.estimate(std::span(frames).first(network.inputs())).slip_index; }).join();
  check(of_thread == answer.slip_index, "threads share a network");

  try {
    tactel::SlipEstimator::load(words[2]);
    check(false, "a missing file is an error");
  } catch (const tactel::InputError& error) {
    check(error.place == words[2] && !error.fix.empty(), "the error names the file");
  }
  std::ifstream file(words[1], std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  int refused = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::vector<char> part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));  // its own end
    try {
      tactel::SlipEstimator::parse(std::as_bytes(std::span(part)), "part");
    } catch (const tactel::Error&) {
      ++refused;
    }
  }
  check(refused == static_cast<int>(bytes.size()), "truncated files are refused");
  return failures != 0;
}
