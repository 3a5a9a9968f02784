// Network files (ONNX). The input is read as it is, then with the checksum of its metadata made right.
#include <onnx/onnx_pb.h>

#include <cmath>

#include "host/networks/onnx_file.h"
#include "host/networks/onnx_graph.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

std::string with_right_checksum(const std::string& bytes) {
  onnx::ModelProto model;
  if (!model.ParsePartialFromString(bytes) || !model.has_graph()) return bytes;
  const std::string sum = host::onnx_checksum(model);
  for (auto& entry : *model.mutable_metadata_props())
    if (entry.key() == host::checksum_key) entry.set_value(sum);
  return model.SerializePartialAsString();
}

void read(const std::string& bytes) {
  const auto path = write_file("network.onnx", as_bytes(bytes));
  accepts([&] {
    const nn::Model model = host::read_onnx(path);
    check(model.weights.values.size() == model.weights.topology.weight_count(), "as many weights as the topology has");
    for (const float weight : model.weights.values) check(std::isfinite(weight), "weights are finite");
    check(host::onnx_bytes(model).size() > 0, "an accepted network can be written again");
  });
}

}  // namespace
}  // namespace tactel::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tactel::fuzz::read_twice(data, size, tactel::fuzz::read, tactel::fuzz::with_right_checksum);
  return 0;
}
