// Where every node stands at one instant, and which morph targets show: keyframes of glTF 2.0
// (appendix C of its specification) and the node forest.
#pragma once

#include <map>
#include <vector>

#include "core/scene/scene.h"

namespace core {

/// The matrices of all nodes into the file's space. The last row, 0 0 0 1, is left out.
struct Pose {
    double time = 0;
    std::vector<glm::dmat4x3> toFile;
    std::map<int, std::vector<double>> weights;  // of the morph targets of nodes that animate them
};

/// Value of a channel at `time` seconds, held outside its keys: xyz, or a unit quaternion as xyzw
/// (rotations go the short way round). A channel without keys gives no value (false).
bool evaluateChannel(const AnimationChannel& channel, double time, glm::dvec4& value);

/// The weights of all morph targets at `time` seconds, held outside the keys; none without keys.
std::vector<double> evaluateWeights(const AnimationChannel& channel, double time);

/// Whether the channel has one value at all times: exporters like to write such channels for every
/// node. Splines count as constant only without tangents.
bool isConstant(const AnimationChannel& channel);

/// The pose at `time` seconds of the first animation; the rest pose when there is none. Rotations
/// are normalised, one without length is the identity. CHECKs that parents come before children.
Pose poseAt(const Scene& scene, double time);

/// The same in the memory of another pose: its matrices stay where they are.
void poseAt(const Scene& scene, double time, Pose& pose);

/// Per node, whether it stands elsewhere at some times than at others: the first animation has a
/// channel for it, or for a node above it, with more than one value.
std::vector<bool> movingNodes(const Scene& scene);

/// The nodes, ascending, whose first animation has weights of morph targets with more than one
/// value.
std::vector<int> morphingNodes(const Scene& scene);

}  // namespace core
