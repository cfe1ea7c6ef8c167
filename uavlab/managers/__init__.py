"""Who flies, and whether it may: what stands between a mission and the parts (MRS Sec. 7). It cannot see the truth."""
