// SPDX-License-Identifier: Apache-2.0

// Networks of other programs (ONNX), as `tactel import-network` reads them. A file w.data of numbers lies beside them.
#include <cmath>

#include "fem/value_error.h"
#include "host/networks/onnx_chain.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  static const auto numbers = fuzz::write_file("w.data", fuzz::as_bytes(std::string(256, '>')));
  const auto path = fuzz::write_file("own.onnx", {data, size});
  host::DenseChain chain;
  if (!fuzz::accepts([&] { chain = host::read_onnx_chain(path); })) return 0;
  fuzz::check(!chain.empty(), "an accepted chain has a layer");
  fuzz::accepts<ValueError>([&] {
    const nn::Weights<float> weights = host::weights_of_chain(chain);
    fuzz::check(weights.values.size() == weights.topology.weight_count(), "as many weights as the topology has");
    for (const float weight : weights.values) fuzz::check(std::isfinite(weight), "weights are finite");
    const double s = host::evaluate(chain, nn::Vector<double>::Zero(weights.topology.inputs()));
    fuzz::check(std::isnan(s) || (s >= 0 && s <= 1), "S is 0..1");
  });
  return 0;
}
