"""Known wrong answers of lab 06, continued: the controller."""

CANARY = "canary-5b50c33888348f636940d189"
