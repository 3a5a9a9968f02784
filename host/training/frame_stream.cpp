// SPDX-License-Identifier: Apache-2.0
#include "host/training/frame_stream.h"

#include "host/scenes/sweep_file.h"
#include "host/sets/contact_set.h"
#include "host/support/errors.h"
#include "host/training/answered_rows.h"

namespace tactel::host {
namespace {

class SimulatedStream : public FrameStream {
 public:
  SimulatedStream(Executor& executor, const std::filesystem::path& file, std::uint64_t contacts,
                  const SetOptions& options)
      : sweep_(read_sweep(file)),
        name_(file.string()),
        contacts_(contacts),
        options_(options),
        simulator_(executor, sweep_.source, options) {
    if (!sweep_.source.endless())
      throw ConfigError(name_, "sweep.set", "a listed set", "left out: a stream draws its contacts (sweep.contacts)");
  }
  nn::FrameSet block(std::uint64_t k) override {
    AnsweredRows rows = answered_rows(simulator_.simulate(k * contacts_, contacts_), name_);
    check_learnable(rows, name_);
    return std::move(rows.frames);
  }
  std::uint64_t blocks() const override { return 1; }
  int inputs() const override { return 2 * sweep_.source.tactels(); }
  std::string description() const override {
    return "simulated " + std::to_string(contacts_) + " contacts a block, precision " +
           std::to_string(static_cast<int>(options_.precision)) + "\n" + sweep_.text;
  }

 private:
  Sweep sweep_;
  std::string name_;
  std::uint64_t contacts_;
  SetOptions options_;
  SetSimulator simulator_;
};

class FileStream : public FrameStream {
 public:
  FileStream(const std::filesystem::path& file, std::uint64_t rows, std::uint64_t seed, nn::PresentationOrder order)
      : name_(file.string()), reader_(file), rows_(rows), seed_(seed), how_(order) {
    if (reader_.rows() == 0) throw ConfigError(name_, "slip_index", "0 rows", "at least one row to learn from");
  }

  nn::FrameSet block(std::uint64_t k) override {
    const auto pass = static_cast<std::uint32_t>(k / blocks());
    if (order_.empty() || pass != pass_)
      order_ = nn::presentation_order(how_, seed_, pass, static_cast<std::uint32_t>(blocks()));
    pass_ = pass;
    const std::uint64_t first = order_[k % blocks()] * rows_;
    AnsweredRows rows = find_answered_rows(reader_.read(first, std::min(rows_, reader_.rows() - first)));
    check_learnable(rows, name_, first);
    return std::move(rows.frames);
  }
  std::uint64_t blocks() const override { return (reader_.rows() + rows_ - 1) / rows_; }
  int inputs() const override { return reader_.inputs(); }
  std::string description() const override {
    return "file " + std::to_string(reader_.rows()) + " rows, " + std::to_string(rows_) + " a block, " +
           nn::name(how_) + ", seed " + std::to_string(seed_) + "\n" + contact_set_sweep(name_);
  }

 private:
  std::string name_;
  ContactSetReader reader_;
  std::uint64_t rows_, seed_;
  nn::PresentationOrder how_;
  std::uint32_t pass_ = 0;
  std::vector<std::uint32_t> order_;
};

}  // namespace

std::unique_ptr<FrameStream> simulated_stream(Executor& executor, const std::filesystem::path& sweep_file,
                                              std::uint64_t contacts, const SetOptions& options) {
  return std::make_unique<SimulatedStream>(executor, sweep_file, contacts, options);
}

std::unique_ptr<FrameStream> file_stream(const std::filesystem::path& set_file, std::uint64_t rows, std::uint64_t seed,
                                         nn::PresentationOrder order) {
  return std::make_unique<FileStream>(set_file, rows, seed, order);
}

}  // namespace tactel::host
