#pragma once
// One job in a forked child. Private to core/tasks.cpp.

#include <functional>
#include <string>

#include "jaculus/core/tasks.h"

namespace jaculus::detail {

/// Runs job() in a child and waits for it; `in_child` runs there first, to let go of what only the
/// parent may hold.
TaskResult run_isolated(const std::function<std::string()>& job, double time_limit_s,
                        const std::function<void()>& in_child);

/// True in a child of run_isolated.
bool is_isolated_child();

}  // namespace jaculus::detail
