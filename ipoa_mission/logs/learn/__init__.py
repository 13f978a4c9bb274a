"""What sets one vehicle apart from the simulated ones, learned from the logs of its flights."""
