"""The controllers of walking robots: four feet and more on points, two on flat soles, and behaviours."""
