// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_spool.h"

#include <gtest/gtest.h>

#include <deque>
#include <fstream>

#include "host/sets/check_set.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t chunk_total = 7;
// HDF5 keeps attributes of more than 4 and of more than 64 KiB as it keeps rows.
const std::string long_name(5'000, 'i'), long_sweep(300'000, '#');

SetColumns columns() {
  SetColumns all(4);
  all.parameters = {"a", "b", "c"}, all.parameter_units = {"mm", "1", "1"};
  all.tactel_x = {-1, 1};
  return only_columns(all, "inputs,status,parameters,tactel_x");
}

/// Chunk k: 8192 to 20 191 rows, a stripe of the set having 8192; one chunk has none.
ContactSet chunk_of(std::uint64_t k) {
  ContactSet chunk(columns());
  const std::size_t rows = k == 4 ? 0 : 8192 + k * 7919 % 12000;
  each_dataset(chunk, [&](const char*, auto& values, int width, const char*) {
    using Value = typename std::remove_reference_t<decltype(values)>::value_type;
    for (std::size_t i = 0; i < rows * static_cast<std::size_t>(std::max(width, 1)); ++i)
      values.push_back(static_cast<Value>((k * 31 + i) % 251));
  });
  chunk.contacts = k + 1 < chunk_total ? 8192 : 100;
  chunk.contact_parameters.assign(3 * chunk.contacts, static_cast<float>(k));
  chunk.fell_back = k;
  return chunk;
}

/// The processes of a run, in turn in this one. Between two turns nothing is under way: a copy of the folder is what a
/// kill at that moment leaves.
class Processes {
 public:
  Processes(const fs::path& output, int processes, SetSpool::Open how) : mail_(static_cast<std::size_t>(processes)) {
    for (int rank = 0; rank < processes; ++rank) {
      const Ring ring{rank, processes, [this](int to, std::string bytes) { mail_.at(to).push_back(std::move(bytes)); },
                      [this, rank] { return take(mail_.at(rank)); }};
      if (rank == 0)
        spools_.push_back(std::make_unique<SetSpool>(output, "plan", columns(), chunk_total, how, ring));
      else
        spools_.push_back(std::make_unique<SetSpool>(output, "plan", columns(), chunk_total, SetSpool::Open::join, ring,
                                                     spools_[0]->chunks()));
      const std::vector<std::uint64_t> missing = spools_.back()->missing();
      missing_.emplace_back(missing.begin(), missing.end());
    }
  }
  SetSpool& spool(std::size_t rank) { return *spools_[rank]; }
  std::size_t letters() const {
    std::size_t all = 0;
    for (const auto& box : mail_) all += box.size();
    return all;
  }

  /// One turn of a process. Returns false where nothing is left to do for it.
  bool turn(std::size_t rank) {
    if (!missing_[rank].empty() && !spools_[rank]->stopped()) {
      spools_[rank]->append(missing_[rank].front(), chunk_of(missing_[rank].front()));
      missing_[rank].pop_front();
    }
    return spools_[rank]->place(std::chrono::milliseconds(0));
  }
  /// Turns until all processes end; calls after() behind each.
  template <class After>
  void to_the_end(const After& after) {
    std::vector<bool> ended(spools_.size());
    for (int round = 0; std::ranges::count(ended, false) > 0; ++round) {
      ASSERT_LT(round, 1000) << "some processes wait for ever";
      for (std::size_t rank = 0; rank < spools_.size(); ++rank) {
        if (ended[rank]) continue;
        // A chunk waits at most: the process would wait for room.
        ended[rank] = !(waits(rank) ? spools_[rank]->place(std::chrono::milliseconds(0)) : turn(rank));
        after();
      }
    }
  }
  void to_the_end() {
    to_the_end([] {});
  }
  /// The bytes of the set.
  std::string finish(const fs::path& output) {
    for (auto& spool : spools_) spool->flush();
    ContactSet set(columns());
    set.contacts = (chunk_total - 1) * 8192 + 100;
    set.sweep = long_sweep, set.indenter_names = {long_name};
    spools_[0]->assemble(set);
    EXPECT_EQ(set.fell_back, chunk_total * (chunk_total - 1) / 2);
    EXPECT_FALSE(fs::exists(SetSpool::folder(output)));
    return text_of(output);
  }

 private:
  static std::optional<std::string> take(std::deque<std::string>& box) {
    if (box.empty()) return {};
    std::string first = std::move(box.front());
    box.pop_front();
    return first;
  }
  /// Whether a chunk of the process waits for those before it.
  bool waits(std::size_t rank) {
    const std::uint64_t next = missing_[rank].empty() ? chunk_total : missing_[rank].front();
    return spools_[rank]->missing().empty() ? false : spools_[rank]->missing().front() < next;
  }

  std::vector<std::deque<std::string>> mail_;
  std::vector<std::unique_ptr<SetSpool>> spools_;
  std::vector<std::deque<std::uint64_t>> missing_;
};

class Spool : public ::testing::Test {
 protected:
  fs::path at(const std::string& name) const { return folder_ / name; }
  std::string made_by(int processes) {
    const fs::path output = at(std::to_string(processes) + ".h5");
    Processes run(output, processes, SetSpool::Open::fresh);
    run.to_the_end();
    return run.finish(output);
  }
  /// Goes on with what a run left, by so many processes.
  std::string resumed(const fs::path& output, int processes) {
    Processes run(output, processes, SetSpool::Open::resume);
    run.to_the_end();
    return run.finish(output);
  }

  ScratchFolder folder_;
};

// HDF5 reads the rows of all chunks, in order, with its own checksums.
TEST_F(Spool, AnyNumberOfProcessesGivesTheSameBytes) {
  const std::string one = made_by(1);
  const ContactSet set = read_contact_set(at("1.h5"));
  ContactSet all(columns());
  for (std::uint64_t k = 0; k < chunk_total; ++k) {
    const ContactSet chunk = chunk_of(k);
    all.frames.insert(all.frames.end(), chunk.frames.begin(), chunk.frames.end());
    all.status.insert(all.status.end(), chunk.status.begin(), chunk.status.end());
    all.contact_parameters.insert(all.contact_parameters.end(), chunk.contact_parameters.begin(),
                                  chunk.contact_parameters.end());
  }
  EXPECT_TRUE(set.frames == all.frames);
  EXPECT_TRUE(set.status == all.status);
  EXPECT_EQ(set.sweep, long_sweep);
  EXPECT_EQ(set.indenter_names, std::vector{long_name});
  EXPECT_TRUE(check_contact_set(at("1.h5"), {}).damage.empty());
  for (const int processes : {2, 3, 7, 9}) EXPECT_TRUE(made_by(processes) == one) << processes;
}

TEST_F(Spool, KilledAtAnyMomentAnyNumberOfProcessesGoesOn) {
  const std::string one = made_by(1);
  const fs::path output = at("set.h5");
  Processes run(output, 3, SetSpool::Open::fresh);
  int moment = 0;
  run.to_the_end([&] {
    const fs::path killed = at("killed.h5");
    fs::copy(SetSpool::folder(output), SetSpool::folder(killed));
    std::uint64_t placed = 0;
    for (int rank = 0; rank < 3; ++rank) placed = std::max(placed, run.spool(rank).chunks());
    const int others = moment++ % 4 + 1;
    {
      const SetSpool first(killed, "plan", columns(), chunk_total, SetSpool::Open::resume);
      EXPECT_GE(first.chunks() + 2, placed);  // two share a stripe at most, and one has no row
    }
    EXPECT_TRUE(resumed(killed, others) == one) << "moment " << moment << ", then " << others << " processes";
  });
  EXPECT_GT(moment, 7);
  EXPECT_TRUE(run.finish(output) == one);
}

// What the processes wrote is not written in the order of the chunks: one in the middle may be missing.
TEST_F(Spool, ATornChunkAndThoseBehindItAreMadeAgain) {
  const std::string one = made_by(1);
  const fs::path output = at("set.h5"), parts = SetSpool::folder(output);
  for (const bool header : {false, true}) {
    {
      Processes run(output, 3, SetSpool::Open::fresh);
      run.to_the_end();
      for (int rank = 0; rank < 3; ++rank) run.spool(rank).flush();
      ASSERT_EQ(run.spool(0).chunks(), chunk_total);
    }
    if (header) {  // the second of its two
      fs::resize_file(parts / "0002.placed", 1.5 * sizeof(ChunkHeader));
    } else {  // in the middle
      std::fstream file(parts / "set", std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(static_cast<std::streamoff>(fs::file_size(parts / "set") / 2));
      file.write("damage", 6);
    }
    {
      const SetSpool first(output, "plan", columns(), chunk_total, SetSpool::Open::resume);
      EXPECT_TRUE(first.torn());
      EXPECT_GT(first.chunks(), 1u);
      EXPECT_LT(first.chunks(), header ? 6u : chunk_total);
    }
    EXPECT_TRUE(resumed(output, 2) == one);
    fs::remove(output);
  }
}

// A process that stops stops all, once the end of the set comes by; no chunk that has its place is lost, and no message
// stays behind.
TEST_F(Spool, AStopOfOneProcessStopsAllAndKeepsTheChunks) {
  const std::string one = made_by(1);
  for (int rounds = 0; rounds < 2; ++rounds)
    for (std::size_t stopper = 0; stopper < 3; ++stopper) {
      const fs::path output = at("set.h5");
      std::uint64_t placed = 0;
      {
        Processes run(output, 3, SetSpool::Open::fresh);
        for (int turn = 0; turn < 5 * rounds; ++turn) run.turn(static_cast<std::size_t>(turn % 3));
        run.spool(stopper).stop();
        run.to_the_end();
        EXPECT_EQ(run.letters(), 0u);
        for (std::size_t rank = 0; rank < 3; ++rank) placed = std::max(placed, run.spool(rank).chunks());
      }
      {
        const SetSpool first(output, "plan", columns(), chunk_total, SetSpool::Open::resume);
        EXPECT_EQ(first.chunks(), placed);
      }
      EXPECT_TRUE(resumed(output, 2) == one);
      fs::remove(output);
    }
}

TEST_F(Spool, AProcessWithAnotherPlanIsAnError) {
  const fs::path output = at("set.h5");
  Processes run(output, 2, SetSpool::Open::fresh);
  const Ring second{.rank = 1, .count = 2};
  EXPECT_THROW(SetSpool(output, "another plan", columns(), chunk_total, SetSpool::Open::join, second), ConfigError);
}

}  // namespace
}  // namespace tactel::host
