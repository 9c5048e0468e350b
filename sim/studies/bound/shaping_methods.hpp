#pragma once
// The shaping methods, which need an account behind them: known to the laboratory, not to sessions.

namespace feltwire {

/// Adds `midpoint`, `credited` and `shaped` to the registry (core/bounding/method.hpp), once. Call
/// it before other threads use the registry.
void add_shaping_methods();

}  // namespace feltwire
