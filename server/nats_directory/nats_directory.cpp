#include "server/nats_directory/nats_directory.hpp"

#include <nats/nats.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>
#include <vector>

namespace feltwire {
namespace {

constexpr std::array<const char*, kBucketCount> kBuckets = {
    "feltwire_hosts", "feltwire_scenes", "feltwire_wishes", "feltwire_tokens"};  // by Bucket
constexpr Nanoseconds kLifetime = std::chrono::seconds(60);                      // but of scenes
constexpr std::string_view kHexDigits = "0123456789ABCDEF";

template <class T, void (*destroy)(T*)>
struct Destroy {
  void operator()(T* object) const { destroy(object); }
};
using Options = std::unique_ptr<natsOptions, Destroy<natsOptions, natsOptions_Destroy>>;
using Nats = std::unique_ptr<natsConnection, Destroy<natsConnection, natsConnection_Destroy>>;
using JetStream = std::unique_ptr<jsCtx, Destroy<jsCtx, jsCtx_Destroy>>;
using Store = std::unique_ptr<kvStore, Destroy<kvStore, kvStore_Destroy>>;
using Watcher = std::unique_ptr<kvWatcher, Destroy<kvWatcher, kvWatcher_Destroy>>;
using Entry = std::unique_ptr<kvEntry, Destroy<kvEntry, kvEntry_Destroy>>;
using Acknowledged = std::unique_ptr<jsPubAck, Destroy<jsPubAck, jsPubAck_Destroy>>;

std::int64_t milliseconds(Nanoseconds time) {
  return std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::milliseconds>(time).count());
}

std::string reason(natsStatus status) {
  const char* const last = nats_GetLastError(nullptr);
  const std::string text = natsStatus_GetText(status);
  return last != nullptr && *last != '\0' ? text + " (" + last + ")" : text;
}

void require(natsStatus status, const std::string& what) {
  if (status != NATS_OK) throw std::runtime_error(what + ": " + reason(status));
}

bool plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_';
}

Options options_of(const NatsOptions& given) {
  natsOptions* made = nullptr;
  require(natsOptions_Create(&made), "the client of NATS");
  Options options(made);
  std::vector<const char*> servers;
  for (const std::string& server : given.servers) servers.push_back(server.c_str());
  const std::string password(given.password.text());
  constexpr int kForEver = -1, kNoBuffer = 1;  // [bytes] 0 would be the default of 8 MB
  require(natsOptions_SetServers(made, servers.data(), static_cast<int>(servers.size())),
          "the list of NATS servers");
  require(natsOptions_SetSecure(made, true), "TLS for NATS");
  require(natsOptions_LoadCATrustedCertificates(made, given.authority.c_str()),
          given.authority.string());
  require(natsOptions_LoadCertificatesChain(made, given.certificate.c_str(), given.key.c_str()),
          given.certificate.string());
  require(natsOptions_SetUserInfo(made, given.user.c_str(), password.c_str()), "the user of NATS");
  require(natsOptions_SetName(made, "feltwire"), "the name for NATS");
  require(natsOptions_SetTimeout(made, milliseconds(given.patience)), "the patience for NATS");
  require(natsOptions_SetMaxReconnect(made, kForEver), "reconnects to NATS");
  require(natsOptions_SetReconnectWait(made, milliseconds(given.patience / 4)),
          "reconnects to NATS");
  // A write without a connection fails at once, and is not sent much later.
  require(natsOptions_SetReconnectBufSize(made, kNoBuffer), "reconnects to NATS");
  require(natsOptions_SetPingInterval(made, milliseconds(2 * given.patience)), "pings to NATS");
  require(natsOptions_SetMaxPingsOut(made, 2), "pings to NATS");
  return options;
}

/// Empty for the entry of a key that was removed, or that another program wrote.
std::optional<DirectoryEntry> entry_of(kvEntry* entry) {
  const auto key = text_of_nats_key(kvEntry_Key(entry));
  if (!key || kvEntry_Operation(entry) != kvOp_Put) return std::nullopt;
  const auto* const bytes = static_cast<const char*>(kvEntry_Value(entry));
  const auto size = static_cast<std::size_t>(std::max(0, kvEntry_ValueLen(entry)));
  return DirectoryEntry{*key, size > 0 ? std::string(bytes, size) : std::string(),
                        kvEntry_Revision(entry)};
}

}  // namespace

std::string nats_key(std::string_view text) {
  std::string key;
  for (const char c : text) {
    if (plain(c)) {
      key += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    key += {'=', kHexDigits[byte >> 4], kHexDigits[byte & 15]};
  }
  return key;
}

std::optional<std::string> text_of_nats_key(std::string_view key) {
  std::string text;
  for (std::size_t i = 0; i < key.size(); ++i) {
    if (plain(key[i])) {
      text += key[i];
      continue;
    }
    if (key[i] != '=' || i + 2 >= key.size()) return std::nullopt;
    const auto high = kHexDigits.find(key[++i]), low = kHexDigits.find(key[++i]);
    if (high == kHexDigits.npos || low == kHexDigits.npos) return std::nullopt;
    text += static_cast<char>((high << 4) | low);
  }
  return text;
}

struct NatsDirectory::Connection {
  explicit Connection(const NatsOptions& given)
      : patience(given.patience), replicas(given.replicas), options(options_of(given)) {}

  /// Connects and opens or makes all buckets; one try.
  natsStatus open() {
    natsStatus status = NATS_OK;
    if (!nats) {
      natsConnection* made = nullptr;
      if ((status = natsConnection_Connect(&made, options.get())) != NATS_OK) return status;
      nats.reset(made);
      jsOptions wait;
      jsOptions_Init(&wait);
      wait.Wait = milliseconds(patience);
      jsCtx* context = nullptr;
      if ((status = natsConnection_JetStream(&context, made, &wait)) != NATS_OK) return status;
      js.reset(context);
    }
    for (std::size_t bucket = 0; bucket < kBuckets.size(); ++bucket) {
      if (stores[bucket]) continue;
      kvStore* store = nullptr;
      status = js_KeyValue(&store, js.get(), kBuckets[bucket]);
      if (status == NATS_NOT_FOUND) {
        kvConfig config;
        kvConfig_Init(&config);
        config.Bucket = kBuckets[bucket];
        config.History = 1;
        config.Replicas = replicas;
        const bool lasting = bucket == static_cast<std::size_t>(Bucket::scenes) ||
                             bucket == static_cast<std::size_t>(Bucket::tokens);
        config.StorageType = lasting ? js_FileStorage : js_MemoryStorage;
        if (!lasting) config.TTL = kLifetime.count();
        status = js_CreateKeyValue(&store, js.get(), &config);
      }
      if (status != NATS_OK) return status;
      stores[bucket].reset(store);
    }
    return NATS_OK;
  }

  WriteAnswer publish(Bucket bucket, const std::string& key, std::string_view value,
                      jsPubOptions& how) {
    how.MaxWait = milliseconds(patience);
    const std::string subject =
        std::string("$KV.") + kBuckets[static_cast<std::size_t>(bucket)] + "." + nats_key(key);
    jsPubAck* made = nullptr;
    jsErrCode error{};
    const natsStatus status = js_Publish(&made, js.get(), subject.c_str(), value.data(),
                                         static_cast<int>(value.size()), &how, &error);
    const Acknowledged acknowledged(made);
    if (status == NATS_OK) return {WriteResult::written, acknowledged->Sequence};
    return {error == JSStreamWrongLastSequenceErr ? WriteResult::conflict : WriteResult::unknown,
            0};
  }

  /// Null: the servers do not answer.
  Watcher watcher(Bucket bucket) {
    kvWatchOptions how;
    kvWatchOptions_Init(&how);
    how.Timeout = milliseconds(patience);
    kvWatcher* made = nullptr;
    kvStore_WatchAll(&made, stores[static_cast<std::size_t>(bucket)].get(), &how);
    return Watcher(made);
  }

  std::uint64_t reconnects() {
    natsStatistics* made = nullptr;
    std::uint64_t count = 0;
    if (natsStatistics_Create(&made) == NATS_OK &&
        natsConnection_GetStats(nats.get(), made) == NATS_OK)
      natsStatistics_GetCounts(made, nullptr, nullptr, nullptr, nullptr, &count);
    natsStatistics_Destroy(made);
    return count;
  }

  Nanoseconds patience;
  int replicas;
  Options options;
  Nats nats;  // destroyed after what uses it
  JetStream js;
  std::array<Store, kBucketCount> stores;
};

namespace {

/// Begins anew after a connection was lost, as its server's end of the watch may be gone.
class NatsWatch final : public DirectoryWatch {
 public:
  NatsWatch(NatsDirectory::Connection& connection, Bucket bucket)
      : connection_(connection), bucket_(bucket) {}

  std::optional<DirectoryEntry> next(Nanoseconds patience) override {
    const std::uint64_t reconnects = connection_.reconnects();
    if (!watcher_ || reconnects != reconnects_) {
      watcher_.reset();
      watcher_ = connection_.watcher(bucket_);
      reconnects_ = reconnects;
      if (!watcher_) return std::nullopt;
    }
    kvEntry* got = nullptr;
    const natsStatus status = kvWatcher_Next(&got, watcher_.get(), milliseconds(patience));
    const Entry entry(got);
    if (status != NATS_OK && status != NATS_TIMEOUT) watcher_.reset();
    return entry ? entry_of(entry.get()) : std::nullopt;  // null also behind the first entries
  }

 private:
  NatsDirectory::Connection& connection_;
  Bucket bucket_;
  Watcher watcher_;
  std::uint64_t reconnects_ = 0;
};

}  // namespace

NatsDirectory::NatsDirectory(const NatsOptions& options)
    : connection_(std::make_unique<Connection>(options)) {
  const auto end = std::chrono::steady_clock::now() + options.open;
  natsStatus status = connection_->open();
  // Servers that have just started are choosing a leader.
  while (status != NATS_OK && std::chrono::steady_clock::now() < end) {
    nats_Sleep(milliseconds(options.patience / 4));
    status = connection_->open();
  }
  if (status == NATS_OK) return;
  std::string servers;
  for (const std::string& server : options.servers)
    servers += (servers.empty() ? "" : ", ") + server;
  throw std::runtime_error("no NATS server of " + servers +
                           " serves the directory: " + reason(status) +
                           "; check the addresses, the certificates, the user, and that JetStream "
                           "is on");
}

NatsDirectory::~NatsDirectory() = default;

WriteAnswer NatsDirectory::compare_and_swap(Bucket bucket, const std::string& key,
                                            std::string_view value, std::uint64_t expected) {
  jsPubOptions how;
  jsPubOptions_Init(&how);
  how.ExpectLastSubjectSeq = expected;
  how.ExpectNoMessage = expected == 0;
  return connection_->publish(bucket, key, value, how);
}

WriteAnswer NatsDirectory::put(Bucket bucket, const std::string& key, std::string_view value) {
  jsPubOptions how;
  jsPubOptions_Init(&how);
  return connection_->publish(bucket, key, value, how);
}

std::optional<std::vector<DirectoryEntry>> NatsDirectory::list(Bucket bucket) {
  const Watcher watcher = connection_->watcher(bucket);
  if (!watcher) return std::nullopt;
  std::vector<DirectoryEntry> entries;
  for (;;) {
    kvEntry* got = nullptr;
    if (kvWatcher_Next(&got, watcher.get(), milliseconds(connection_->patience)) != NATS_OK)
      return std::nullopt;
    if (got == nullptr) break;  // that was all
    const Entry entry(got);
    if (auto read = entry_of(got)) entries.push_back(std::move(*read));
  }
  std::ranges::sort(entries, {}, &DirectoryEntry::key);
  return entries;
}

std::unique_ptr<DirectoryWatch> NatsDirectory::watch(Bucket bucket) {
  return std::make_unique<NatsWatch>(*connection_, bucket);
}

std::optional<std::string> NatsDirectory::leader(Bucket bucket) {
  const std::string stream = std::string("KV_") + kBuckets[static_cast<std::size_t>(bucket)];
  jsStreamInfo* made = nullptr;
  js_GetStreamInfo(&made, connection_->js.get(), stream.c_str(), nullptr, nullptr);
  const std::unique_ptr<jsStreamInfo, Destroy<jsStreamInfo, jsStreamInfo_Destroy>> info(made);
  if (!info || info->Cluster == nullptr || info->Cluster->Leader == nullptr) return std::nullopt;
  return info->Cluster->Leader;
}

}  // namespace feltwire
