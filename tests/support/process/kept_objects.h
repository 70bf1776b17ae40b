// What all tests of a process share and main() takes down after the last of them. Static objects
// would go later: after what drivers and the validation layer keep in theirs, and while a driver
// that has put its compiler away may still be compiling on a thread of a renderer.
#pragma once

#include <memory>
#include <vector>

namespace tests {

inline std::vector<std::shared_ptr<void>>& keptObjects()
{
    static std::vector<std::shared_ptr<void>> objects;
    return objects;
}

template <class T> T& kept(std::unique_ptr<T> object)
{
    T& it = *object;
    keptObjects().push_back(std::move(object));
    return it;
}

/// The last one first.
inline void releaseKeptObjects()
{
    while (!keptObjects().empty()) keptObjects().pop_back();
}

}  // namespace tests
