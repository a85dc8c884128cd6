"""The tier `tracked`: a detector that errs as detectors do, and a real tracker behind it."""
