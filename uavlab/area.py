"""Where one may fly: a safety area with no-fly zones (MRS Sec. 7.2)."""
