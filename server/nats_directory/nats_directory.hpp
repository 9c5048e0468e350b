#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/fleet/directory.hpp"
#include "server/fleet/nats_options.hpp"

namespace feltwire {

/// A directory in the JetStream key-value buckets `feltwire_hosts` and `feltwire_wishes` (in
/// memory; a key disappears silently 60 s after its last write), `feltwire_scenes` and
/// `feltwire_tokens` (in files).
/// The first host makes them. An answer to a write says that a majority of the servers has it;
/// whether it outlives the power of all of them is a matter of their option sync_interval
/// (docs/fleet.md).
class NatsDirectory final : public Directory {
 public:
  /// Throws std::runtime_error with the remedy if no server answers within `options.open`, refuses
  /// this host, or cannot make the buckets.
  explicit NatsDirectory(const NatsOptions& options);
  ~NatsDirectory() override;

  WriteAnswer compare_and_swap(Bucket bucket, const std::string& key, std::string_view value,
                               std::uint64_t expected) override;
  WriteAnswer put(Bucket bucket, const std::string& key, std::string_view value) override;
  std::optional<std::vector<DirectoryEntry>> list(Bucket bucket) override;
  std::unique_ptr<DirectoryWatch> watch(Bucket bucket) override;

  /// The name of the server that takes the writes of a bucket; empty: no answer, or there is none.
  std::optional<std::string> leader(Bucket bucket);

  struct Connection;

 private:
  std::unique_ptr<Connection> connection_;
};

/// Any text as a key of NATS, which allows letters, digits and a few signs: other bytes become =XX.
std::string nats_key(std::string_view text);
/// Empty for a key that nats_key() does not write.
std::optional<std::string> text_of_nats_key(std::string_view key);

}  // namespace feltwire
