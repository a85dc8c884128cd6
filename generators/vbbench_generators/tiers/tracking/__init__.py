"""The tier `tracked`: a simulated detector, and a real tracker of its detections."""
