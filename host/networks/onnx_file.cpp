// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_file.h"

#include <fmt/format.h>

#include "host/support/bounded_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "nn/infer/built_in.h"
#include "nn/infer/network_file.h"

namespace tactel::host {

namespace fs = std::filesystem;

void write_onnx(const fs::path& path, const nn::Model& model) {
  write_file("--output", path, infer::network_bytes(model));
}

nn::Model read_onnx(const fs::path& path) try {
  if (const std::string_view bytes = infer::built_in_network(path.string()); !bytes.empty())
    return infer::read_network(bytes).model;
  return infer::read_network(read_bounded_file(path, infer::most_network_bytes)).model;
} catch (const UnreadableFile& error) {
  throw ConfigError(path.string(), "network", std::string("cannot be read (") + error.what() + ")",
                    "a network that tactel wrote (ONNX, at most 4 MiB)");
} catch (const ValueError& error) {
  throw ConfigError(path.string(), error);
}

std::string network_file_name(const nn::Topology& topology, double noise, std::uint64_t seed) {
  return fmt::format("{}_noise{}_seed{}.onnx", topology.text(), noise, seed);
}

}  // namespace tactel::host
