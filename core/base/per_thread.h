// What a thread works with, made when it first does.
#pragma once

#include <memory>

namespace core {

/// This thread's T. A `thread_local T` would be part of every thread of the process from its start,
/// those of drivers and libraries included, and a software device starts dozens.
template <class T> T& perThread()
{
    static thread_local std::unique_ptr<T> mine;
    if (!mine) mine = std::make_unique<T>();
    return *mine;
}

}  // namespace core
