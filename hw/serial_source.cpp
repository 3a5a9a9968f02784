// SPDX-License-Identifier: Apache-2.0
#include "hw/serial_source.h"

namespace tactel::hw {

std::optional<Packet> SerialSource::wait(double timeout) {
  const Bytes bytes = port_.read(timeout);
  if (bytes.empty()) return std::nullopt;
  ++counts_.packets, counts_.bytes += bytes.size();
  return Packet{bytes, now(), port_.take_gap()};
}

TransportCounts SerialSource::counts() const {
  TransportCounts counts = counts_;
  counts.reconnects = port_.reconnects();
  return counts;
}

}  // namespace tactel::hw
