// SPDX-License-Identifier: Apache-2.0
#include "host/live/frame_reader.h"

#include <gmock/gmock.h>

#include "tests/host/live/simulated_frames.h"

namespace tactel::host::frame_reader_test {

// Half a frame, then the device was away: the half is no damage, and does not take the next frame along.
TEST(ReadFrames, AGapInterruptsTheDecoder) {
  const auto [bytes, profile] = simulated_bytes();
  const std::size_t length = bytes.size() / 321;
  class Source final : public hw::FrameSource {
   public:
    Source(hw::Bytes half, hw::Bytes whole) : packets_{{half, 1.0, false}, {whole, 2.0, true}} {}
    std::optional<hw::Packet> wait(double) override { return packets_[at_++]; }
    bool finished() const override { return at_ == 2; }
    bool live() const override { return false; }
    double now() const override { return 0; }
    hw::TransportCounts counts() const override { return {}; }

   private:
    std::vector<hw::Packet> packets_;
    std::size_t at_ = 0;
  } source(hw::Bytes(bytes).first(length / 2), hw::Bytes(bytes).subspan(length, length));
  hw::Decoder decoder(profile.format());
  std::vector<double> arrivals;
  int packets = 0, turns = 0;
  read_frames(source, decoder,
              {.packet = [&](const hw::Packet&) { ++packets; },
               .frame = [&](const hw::DecodedFrame&, double arrival) { arrivals.push_back(arrival); },
               .turn = [&] { ++turns; }});
  EXPECT_EQ(arrivals, std::vector<double>{2.0});
  EXPECT_EQ(decoder.counts().bad, 0u);
  EXPECT_EQ(packets, 2);
  EXPECT_EQ(turns, 2);
}

}  // namespace tactel::host::frame_reader_test
