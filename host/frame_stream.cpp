#include "host/frame_stream.h"

#include "host/contact_set.h"
#include "host/named_network.h"
#include "host/sweep_file.h"
#include "nn/presentation_order.h"

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
    return answered_rows(simulator_.simulate(k * contacts_, contacts_), name_).frames;
  }
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
  FileStream(const std::filesystem::path& file, std::uint64_t rows, std::uint64_t seed)
      : name_(file.string()), reader_(file), rows_(rows), seed_(seed) {}

  nn::FrameSet block(std::uint64_t k) override {
    const std::uint64_t blocks = (reader_.rows() + rows_ - 1) / rows_;
    const auto pass = static_cast<std::uint32_t>(k / blocks);
    if (order_.empty() || pass != pass_)
      order_ = nn::presentation_order(nn::PresentationOrder::permuted, seed_, pass, static_cast<std::uint32_t>(blocks));
    pass_ = pass;
    const std::uint64_t first = order_[k % blocks] * rows_;
    return answered_rows(reader_.read(first, std::min(rows_, reader_.rows() - first)), name_).frames;
  }
  int inputs() const override { return reader_.inputs(); }
  std::string description() const override {
    return "file " + std::to_string(reader_.rows()) + " rows, " + std::to_string(rows_) + " a block, seed " +
           std::to_string(seed_) + "\n" + contact_set_sweep(name_);
  }

 private:
  std::string name_;
  ContactSetReader reader_;
  std::uint64_t rows_, seed_;
  std::uint32_t pass_ = 0;
  std::vector<std::uint32_t> order_;
};

}  // namespace

std::unique_ptr<FrameStream> simulated_stream(Executor& executor, const std::filesystem::path& sweep_file,
                                              std::uint64_t contacts, const SetOptions& options) {
  return std::make_unique<SimulatedStream>(executor, sweep_file, contacts, options);
}

std::unique_ptr<FrameStream> file_stream(const std::filesystem::path& set_file, std::uint64_t rows,
                                         std::uint64_t seed) {
  return std::make_unique<FileStream>(set_file, rows, seed);
}

}  // namespace tactel::host
