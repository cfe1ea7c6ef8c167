"""Lab 06, hidden checks, continued: the parts in flight."""

CANARY = "canary-dae29abf2f99be6782ca7925"
