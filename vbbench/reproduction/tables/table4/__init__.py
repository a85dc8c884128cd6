"""The paper's Table 4: centre lines drawn by hand, and boxes of a tracker."""
