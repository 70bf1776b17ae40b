// Queues of paths that are alive. Whoever includes this has declared their heads: QueueHead queues[].

/// Appends the lanes that are `alive` to the queue of the next bounce: one atomic per subgroup, no barrier.
uint queueSlot(bool alive, uint next)
{
    const uvec4 ballot = subgroupBallot(alive);
    const uint count = subgroupBallotBitCount(ballot);
    uint base = 0u;
    if (subgroupElect() && count > 0u) {
        base = atomicAdd(queues[next].count, count);
        atomicMax(queues[next].groupsX, (base + count + kGroupSize - 1u) / kGroupSize);
    }
    return subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(ballot);
}
