"""Known wrong answers of lab 06, continued: the tracker."""

CANARY = "canary-f0c127673b6af8399642f54c"
