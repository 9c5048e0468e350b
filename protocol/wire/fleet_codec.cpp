#include "protocol/wire/fleet_codec.hpp"

#include <algorithm>

#include "protocol/wire/control_values.hpp"

namespace feltwire::control {
namespace {

flatbuffers::Offset<wire::FleetHost> build_host(flatbuffers::FlatBufferBuilder& builder,
                                                const FleetHost& host) {
  const auto address = builder.CreateString(host.address);
  const auto fingerprint = builder.CreateVector(host.fingerprint.data(), host.fingerprint.size());
  return wire::CreateFleetHost(builder, address, host.port, fingerprint);
}

bool read_host(const wire::FleetHost& from, FleetHost& to) {
  const auto& fingerprint = *from.fingerprint();
  if (fingerprint.size() != to.fingerprint.size()) return false;
  std::copy(fingerprint.begin(), fingerprint.end(), to.fingerprint.begin());
  to.port = from.port();
  return read_name(from.address(), to.address);
}

}  // namespace

flatbuffers::Offset<WireHosts> build(flatbuffers::FlatBufferBuilder& builder,
                                     const std::vector<FleetHost>& hosts) {
  if (hosts.empty()) return 0;
  std::vector<flatbuffers::Offset<wire::FleetHost>> built;
  built.reserve(hosts.size());
  for (const FleetHost& host : hosts) built.push_back(build_host(builder, host));
  return builder.CreateVector(built);
}

flatbuffers::Offset<wire::Redirected> build(flatbuffers::FlatBufferBuilder& builder,
                                            const Redirected& redirected) {
  const auto host = build_host(builder, redirected.host);
  const auto ticket = builder.CreateString(redirected.ticket);
  return wire::CreateRedirected(builder, host, ticket, redirected.epoch.term,
                                redirected.epoch.holder);
}

bool read(const WireHosts* hosts, std::vector<FleetHost>& to) {
  if (hosts == nullptr) return true;
  if (hosts->size() > kMaxFleetHosts) return false;
  return std::ranges::all_of(*hosts,
                             [&](const auto* host) { return read_host(*host, to.emplace_back()); });
}

bool read(const wire::Redirected& from, Redirected& to) {
  to.epoch = {from.term(), from.holder()};
  return read_name(from.ticket(), to.ticket, kMaxTicket) && read_host(*from.host(), to.host);
}

}  // namespace feltwire::control
