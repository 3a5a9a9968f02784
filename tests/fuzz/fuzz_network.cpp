// SPDX-License-Identifier: Apache-2.0

// Network files (ONNX), by the program's reader and that of tactel::infer. The input is read as it is, then with the
// checksum of its metadata made right.
#include <tactel/infer.h>

#include <cmath>
#include <vector>

#include "host/networks/onnx_file.h"
#include "nn/infer/network_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/host/networks/crafted_network.h"

namespace tactel::fuzz {
namespace {

std::string with_right_checksum(const std::string& bytes) {
  onnx::ModelProto model;
  return model.ParsePartialFromString(bytes) && model.has_graph() ? tests::sealed(model) : bytes;
}

void read(const std::string& bytes) {
  const auto path = write_file("network.onnx", as_bytes(bytes));
  accepts([&] {
    const nn::Model model = host::read_onnx(path);
    check(model.weights.values.size() == model.weights.topology.weight_count(), "as many weights as the topology has");
    for (const float weight : model.weights.values) check(std::isfinite(weight), "weights are finite");
    check(infer::read_network(infer::network_bytes(model)).model.weights.values == model.weights.values,
          "an accepted network can be written again");
  });
}

void infer(const std::string& bytes) {
  accepts<InputError>([&] {
    const SlipEstimator estimator = SlipEstimator::parse(std::as_bytes(std::span(bytes)));
    const std::vector<float> frame(estimator.inputs(), -0.1f);
    const Answer answer = estimator.estimate(frame);
    check(answer.status == AnswerStatus::overflow || (answer.slip_index >= 0 && answer.slip_index <= 1), "S is 0..1");
  });
}

void read_and_infer(const std::string& bytes) {
  read(bytes);
  infer(bytes);
}

const Target network("network", [](Bytes input) { read_twice(input, read_and_infer, with_right_checksum); });

}  // namespace
}  // namespace tactel::fuzz
