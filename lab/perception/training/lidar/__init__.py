"""The LiDAR detector: targets, network, training, export."""
