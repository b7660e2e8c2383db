"""The camera networks: attributes from crops of detected objects, and detection of far vehicles."""
