// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_spool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "host/sets/check_set.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::set_spool_test {

namespace fs = std::filesystem;

constexpr std::uint64_t chunk_total = 7;
// HDF5 keeps attributes of more than 4 and of more than 64 KiB as it keeps rows.
const std::string long_name(5'000, 'i'), long_sweep(300'000, '#');

SetColumns columns() {
  SetColumns all(4);
  all.parameter_names = {"a", "b", "c"}, all.parameter_units = {"mm", "1", "1"};
  all.tactel_x = {-1, 1};
  return only_columns(all, "inputs,status,parameters,tactel_x");
}

/// Chunk k: 8192 to 20 191 rows, where HDF5's chunks have 8192; one has none.
ContactSet chunk_of(std::uint64_t k) {
  ContactSet chunk(columns());
  const std::size_t rows = k == 4 ? 0 : 8192 + k * 7919 % 12000;
  each_dataset(chunk, [&](const char*, auto& values, int width, const char*) {
    using Value = typename std::remove_reference_t<decltype(values)>::value_type;
    for (std::size_t i = 0; i < rows * static_cast<std::size_t>(std::max(width, 1)); ++i)
      values.push_back(static_cast<Value>((k * 31 + i) % 251));
  });
  chunk.contacts = k + 1 < chunk_total ? 8192 : 100;
  chunk.parameters.assign(3 * chunk.contacts, static_cast<float>(k));
  chunk.fell_back = k;
  return chunk;
}

/// The processes of a run, in this one.
class Processes {
 public:
  Processes(const fs::path& output, int processes, SetSpool::Open how) : output_(output) {
    for (int process = 0; process < processes; ++process)
      spools_.push_back(std::make_unique<SetSpool>(output, "plan", columns(), chunk_total,
                                                   process == 0 ? how : SetSpool::Open::join, process));
    for (int process = 0; process < processes; ++process)
      for (const std::uint64_t chunk : missing_chunks(spools_[0]->found(), process, processes))
        missing_.emplace_back(chunk, process);
  }
  SetSpool& spool(std::size_t process) { return *spools_[process]; }
  std::size_t missing() const { return missing_.size(); }

  /// Makes the missing chunks, those of the last process first; calls after() behind each.
  template <class After>
  void to_the_end(const After& after) {
    for (; !missing_.empty(); missing_.pop_back(), after())
      spools_[static_cast<std::size_t>(missing_.back().second)]->append(missing_.back().first,
                                                                        chunk_of(missing_.back().first));
  }
  /// The bytes of the set.
  std::string finish() {
    to_the_end([] {});
    for (auto& spool : spools_) spool->flush();
    ContactSet set(columns());
    set.contacts = (chunk_total - 1) * 8192 + 100;
    set.sweep = long_sweep, set.indenter_names = {long_name};
    spools_[0]->assemble(set);
    EXPECT_EQ(set.fell_back, chunk_total * (chunk_total - 1) / 2);
    EXPECT_FALSE(fs::exists(SetSpool::folder(output_)));
    return text_of(output_);
  }

 private:
  fs::path output_;
  std::vector<std::unique_ptr<SetSpool>> spools_;
  std::vector<std::pair<std::uint64_t, int>> missing_;
};

class Spool : public ::testing::Test {
 protected:
  fs::path at(const std::string& name) const { return folder_ / name; }
  /// The chunks that a run of so many processes finds, and whether some were torn.
  static std::pair<std::size_t, bool> found(const fs::path& output) {
    const SetSpool first(output, "plan", columns(), chunk_total, SetSpool::Open::resume);
    return {chunk_total - missing_chunks(first.found()).size(), first.torn()};
  }

  ScratchFolder folder_;
  const std::string whole_ = Processes(at("1.h5"), 1, SetSpool::Open::fresh).finish();
};

// HDF5 reads the rows of all chunks, in order, with its own checksums.
TEST_F(Spool, AnyNumberOfProcessesGivesTheSameBytes) {
  const ContactSet set = read_contact_set(at("1.h5"));
  ContactSet all(columns());
  for (std::uint64_t k = 0; k < chunk_total; ++k) {
    const ContactSet chunk = chunk_of(k);
    all.frames.insert(all.frames.end(), chunk.frames.begin(), chunk.frames.end());
    all.status.insert(all.status.end(), chunk.status.begin(), chunk.status.end());
    all.parameters.insert(all.parameters.end(), chunk.parameters.begin(), chunk.parameters.end());
  }
  EXPECT_TRUE(set.frames == all.frames);
  EXPECT_TRUE(set.status == all.status);
  EXPECT_TRUE(set.parameters == all.parameters);
  EXPECT_EQ(set.tactel_x, columns().tactel_x);
  EXPECT_EQ(set.sweep, long_sweep);
  EXPECT_EQ(set.indenter_names, std::vector{long_name});
  EXPECT_TRUE(check_contact_set(at("1.h5"), {}).damage.empty());
  for (const int processes : {2, 3, 7, 9})
    EXPECT_TRUE(Processes(at("set.h5"), processes, SetSpool::Open::fresh).finish() == whole_) << processes;
}

TEST_F(Spool, ThreadsAppendAtOnce) {
  const fs::path output = at("set.h5");
  Processes run(output, 1, SetSpool::Open::fresh);
  {
    std::vector<std::jthread> threads;
    for (std::uint64_t k = 0; k < chunk_total; ++k)
      threads.emplace_back([&run, k] { run.spool(0).append(k, chunk_of(k)); });
  }
  EXPECT_EQ(run.spool(0).bytes() + chunk_total * sizeof(ChunkHeader), SetSpool::bytes_left(output));
  fs::copy(SetSpool::folder(output), SetSpool::folder(at("killed.h5")));
  EXPECT_EQ(found(at("killed.h5")), std::pair(chunk_total, false));
  EXPECT_TRUE(Processes(at("killed.h5"), 1, SetSpool::Open::resume).finish() == whole_);
}

TEST_F(Spool, KilledAtAnyMomentAnyNumberOfProcessesGoesOn) {
  const fs::path output = at("set.h5"), killed = at("killed.h5");
  Processes run(output, 3, SetSpool::Open::fresh);
  std::size_t made = 0;
  run.to_the_end([&] {
    fs::copy(SetSpool::folder(output), SetSpool::folder(killed));
    EXPECT_EQ(found(killed), std::pair(++made, false));
    const int others = static_cast<int>(made) % 4 + 1;
    EXPECT_TRUE(Processes(killed, others, SetSpool::Open::resume).finish() == whole_)
        << made << " chunks, then " << others << " processes";
  });
  EXPECT_EQ(made, chunk_total);
  EXPECT_TRUE(run.finish() == whole_);
}

// The first of three processes has chunks 6, 3 and 0, in this order. Cut within one, or damaged.
TEST_F(Spool, TornAndDamagedChunksAreMadeAgain) {
  constexpr std::uint64_t header = sizeof(ChunkHeader);
  const auto bytes = [](std::uint64_t k) { return header + chunk_of(k).rows() * 21 + chunk_of(k).contacts * 12; };
  const std::uint64_t third = bytes(6) + bytes(3), end = third + bytes(0);
  struct Damage {
    std::uint64_t at;
    bool cut;
    std::size_t left;
  };
  for (const auto& [place, cut, left] : std::vector<Damage>{{end - 1, true, 6},
                                                            {third + header + 1, true, 6},
                                                            {third + header, true, 6},
                                                            {third + 1, true, 6},
                                                            {bytes(6) + header + 5, true, 5},
                                                            {0, true, 4},
                                                            {end - 1, false, 6},
                                                            {bytes(6) + header + 5, false, 6},
                                                            {bytes(6) + 20, false, 5},
                                                            {header + 8, false, 6}}) {
    const fs::path output = at("set.h5"), file = SetSpool::folder(output) / "0000.chunks";
    {
      Processes run(output, 3, SetSpool::Open::fresh);
      run.to_the_end([] {});
    }
    ASSERT_EQ(fs::file_size(file), end);
    if (cut) {
      fs::resize_file(file, place);
    } else {
      std::fstream open(file, std::ios::in | std::ios::out | std::ios::binary);
      open.seekp(static_cast<std::streamoff>(place)).put('\xfe');
    }
    EXPECT_EQ(found(output), std::pair(left, place > 0)) << place;
    EXPECT_TRUE(Processes(output, 2, SetSpool::Open::resume).finish() == whole_) << place;
    fs::remove(output);
  }
}

// A limit on the size of files stands for a full disk.
TEST_F(Spool, ACompressedSetHasNoChunkThatWasDamagedSince) {
  const fs::path output = at("set.h5");
  {
    Processes run(output, 2, SetSpool::Open::fresh);
    run.to_the_end([] {});
    std::fstream(SetSpool::folder(output) / "0001.chunks", std::ios::in | std::ios::out | std::ios::binary)
        .seekp(sizeof(ChunkHeader) + 5)
        .put('?');
    ContactSet set(columns());
    EXPECT_THROW(run.spool(0).assemble(set, true), ConfigError);
  }
  EXPECT_EQ(found(output), std::pair(chunk_total - 1, true));
  EXPECT_TRUE(Processes(output, 1, SetSpool::Open::resume).finish() == whole_);
}

TEST_F(Spool, AChunkThatDoesNotFitLeavesTheOthersWhole) {
  const fs::path output = at("set.h5"), file = SetSpool::folder(output) / "0000.chunks";
  {
    SetSpool spool(output, "plan", columns(), chunk_total, SetSpool::Open::fresh);
    spool.append(0, chunk_of(0));
    const std::uint64_t size = fs::file_size(file);
    rlimit usual{};
    ::getrlimit(RLIMIT_FSIZE, &usual);
    const rlimit full{size + 1000, usual.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &full);
    EXPECT_THROW(spool.append(1, chunk_of(1)), ConfigError);
    ::setrlimit(RLIMIT_FSIZE, &usual);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(fs::file_size(file), size);
    spool.append(2, chunk_of(2));
    ContactSet set(columns());
    EXPECT_THROW(spool.assemble(set), ConfigError);
  }
  EXPECT_EQ(found(output), std::pair(std::size_t{2}, false));
  EXPECT_TRUE(Processes(output, 2, SetSpool::Open::resume).finish() == whole_);
}

TEST_F(Spool, AStopOfOneProcessIsSeenByAllAndNotByTheNextRun) {
  const fs::path output = at("set.h5");
  for (std::size_t stopper = 0; stopper < 3; ++stopper) {
    Processes run(output, 3, stopper == 0 ? SetSpool::Open::fresh : SetSpool::Open::resume);
    for (std::size_t process = 0; process < 3; ++process) EXPECT_FALSE(run.spool(process).stopped());
    run.spool(stopper).stop();
    for (std::size_t process = 0; process < 3; ++process) EXPECT_TRUE(run.spool(process).stopped());
  }
  EXPECT_TRUE(Processes(output, 1, SetSpool::Open::resume).finish() == whole_);
}

// A process that outlives the others of its run: nothing may come between its chunks.
TEST_F(Spool, NoRunGoesOnWhileAProcessWrites) {
  const fs::path output = at("set.h5");
  auto first = std::make_unique<SetSpool>(output, "plan", columns(), chunk_total, SetSpool::Open::fresh);
  auto second = std::make_unique<SetSpool>(output, "plan", columns(), chunk_total, SetSpool::Open::join, 1);
  second->append(1, chunk_of(1));
  first.reset();
  EXPECT_THROW(found(output), ConfigError);
  second.reset();
  EXPECT_EQ(found(output), std::pair(std::size_t{1}, false));
}

TEST_F(Spool, AProcessWithAnotherPlanIsAnError) {
  const fs::path output = at("set.h5");
  const Processes run(output, 1, SetSpool::Open::fresh);
  EXPECT_THROW(SetSpool(output, "another plan", columns(), chunk_total, SetSpool::Open::join, 1), ConfigError);
}

}  // namespace tactel::host::set_spool_test
